//! What was found once, by its name: each must be refused with these words, or read in no time.

use super::scenes::READING;
use cpu_time::ThreadTime;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

fn open(name: &str, changes: &[&str]) -> Result<wheelrail::scene::spec::Scene, String> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let started = ThreadTime::now();
    let scene = load::open(name, &changes).map_err(|error| error.to_string());
    let taken = started.elapsed().as_secs_f64();
    assert!(taken < READING, "{changes:?}: {taken:.1} s");
    scene
}

#[test]
fn regress_sizes_beyond_any_railway_are_refused_where_they_stand() {
    let cases = [
        // 12.8 TB of pieces; a panic.
        ("track.node=[{distance=0}, {distance=100, radius=500}, {distance=1e14, radius=500}]", "at most 1e7 m either way"),
        ("track.node=[{distance=0}, {distance=100, radius=500}, {distance=1e30}]", "at most 1e7 m either way"),
        ("track.node=[{distance=0}, {distance=100, radius=10}, {distance=1e6, radius=10}]", "turns by more than 25000.0 rad"),
        ("track.rail={kind=\"arc\", radius=1e300}", "track.rail.radius"),
        ("track.rail={kind=\"arc\", radius=1e-6}", "found 1e-6 m, expected 0.001 m to 1000.0 m"),
        ("track.rail={kind=\"points\", file=\"/dev/zero\"}", "an embedded scene has no folder"),
        ("vehicle.wheelset.mass=\"1e300 t\"", "of at most 1e9 kg either way"),
        // A yaw frequency of 3e6 rad/s: explicit steps without end.
        ("vehicle.suspension.distance=2e5", "found 200000.0 m, expected 0.0 m to 10.0 m"),
        ("vehicle.gravity=1e200", "of at most 1e4 m/s2 either way"),
        ("track.deviation=[{rail=\"left\", direction=\"lateral\", shape=\"cosine\", amplitude=0.01, from=10, to=1e300}]", "at most 1e7 m"),
    ];
    for (change, words) in cases {
        let error = open("suspended_wheelset", &[change]).err().unwrap_or_default();
        assert!(error.contains(words) && error.contains("suspended_wheelset.toml:"), "{change}: {error}");
    }
}

/// Stretches of 1 mm over the whole arc took minutes.
#[test]
fn regress_wide_arcs_are_ready_at_once() {
    for (scene, radius) in
        [("suspended_wheelset", 1.2), ("suspended_wheelset", 3.0), ("suspended_wheelset", 300.0), ("wheelset_s1002", 1e3)]
    {
        let scene = open(scene, &[&format!("track.rail={{kind=\"arc\", radius={radius}}}"), "contact.formulation=ECF-A"]);
        if let Ok(scene) = scene {
            let started = ThreadTime::now();
            let _ = Simulation::new(&scene, 0.0).map(|mut simulation| simulation.advance(0.01));
            assert!(started.elapsed().as_secs_f64() < READING, "{radius}");
        }
    }
}

#[test]
fn regress_a_device_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let scene = wheelrail::scene::embedded::find("wheelset_s1002").unwrap().text;
    let path = folder.path().join("a.toml");
    std::fs::write(&path, scene).unwrap();
    for file in ["/dev/zero", "."] {
        let error = open(path.to_str().unwrap(), &[&format!("track.rail={{kind=\"points\", file=\"{file}\"}}")]).err().unwrap_or_default();
        assert!(error.contains("it is no file") || error.contains("can't read"), "{error}");
    }
}

/// "The system can't be evaluated", without a reason, by each implicit method.
#[test]
fn regress_without_friction_a_standing_wheelset_is_integrated_by_every_method() {
    for integrator in ["rosenbrock", "imex", "generalised_alpha", "real_time", "dormand_prince"] {
        for friction in ["0", "1e-12", "1e-6"] {
            let integrator = format!("solver.integrator={integrator}");
            let friction = format!("contact.friction={friction}");
            let changes =
                [&integrator, &friction, "vehicle.speed=0", "contact.creep={law=\"polach\"}", "solver.tolerance=1e-6", "solver.step=0.001"];
            let scene = open("wheelset_standstill", &changes).unwrap();
            let mut simulation = Simulation::new(&scene, 0.0).unwrap();
            simulation.advance(0.5).unwrap_or_else(|error| panic!("{integrator} {friction}: {error}"));
            let snapshot = simulation.snapshot().unwrap();
            // It slides down the grade of 0.03 rad; the load on it is vertical to the track.
            let (expected, speed) = (-9.81 * 0.03f64.sin() * 0.5, snapshot.y[6]);
            println!("{integrator} {friction}: {speed} m/s, {expected}");
            assert!((speed / expected - 1.0).abs() < 1e-3, "{integrator} {friction}: {speed}");
            assert!(snapshot.dy.iter().all(|value| value.is_finite()));
        }
    }
}

/// 33 GB of parts of a track that long; two heights at one place, which made the profile no number.
#[test]
fn regress_files_with_impossible_places_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let scene = wheelrail::scene::embedded::find("wheelset_s1002").unwrap().text;
    let path = folder.path().join("a.toml");
    std::fs::write(&path, scene).unwrap();
    let refused = |content: &str, change: &str| {
        std::fs::write(folder.path().join("a.csv"), content).unwrap();
        open(path.to_str().unwrap(), &[change]).err().unwrap_or_default()
    };
    let series = "distance [m],alignment [mm]\n0,0\n1,1\n2,0\n3,-1\n1e30,0\n";
    let error = refused(series, "track.irregularity=[{kind=\"series\",file=\"a.csv\"}]");
    assert!(error.contains("1e30 m") && error.contains("at most 1e7 m either way"), "{error}");
    let rail = "eta [mm],height [mm]\n-30,-5\n-20,-1\n-10,-0.2\n-1e-16,0\n-2.5e-6,1\n10,-0.2\n20,-1\n30,-5\n";
    let error = refused(rail, "track.rail={kind=\"points\",file=\"a.csv\"}");
    assert!(error.contains("a.csv") && !error.contains("NaN"), "{error}");
}

/// Points out of order whose spline rises to 43 m with slopes beyond all measure: looking at the gap beside a contact never ended.
#[test]
fn regress_a_wheel_of_spikes_is_started_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, wheelrail::scene::embedded::find("wheelset_s1002").unwrap().text).unwrap();
    std::fs::write(folder.path().join("a.csv"), include_str!("../data/fuzz/spiked_wheel.csv")).unwrap();
    let wheel = "vehicle.wheelset.profile={kind=\"points\",radius=0.46,drop_outliers=true,smoothing=1e-5,file=\"a.csv\"}";
    let Ok(scene) = open(path.to_str().unwrap(), &[wheel]) else { return };
    let started = ThreadTime::now();
    let came = Simulation::new(&scene, 0.0).map(|_| ()).map_err(|error| error.to_string());
    println!("{came:?} after {:.2} s", started.elapsed().as_secs_f64());
    assert!(started.elapsed().as_secs_f64() < 20.0);
}
