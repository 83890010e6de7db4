//! Modes of the bodies on their springs, wheelsets held, against the eigenvalues of the whole vehicle on its rails.

use wheelrail::mbs::carried::Carried;
use wheelrail::scene::load;
use wheelrail::scene::vehicle::assemble::{design, parts};
use wheelrail::study::modes::modes;

/// A light box on a car, on springs alone, with a damper, and with a damper in series with a spring: rate and damping ratio of its bounce.
#[test]
fn equiv_swings_of_a_box_are_the_eigenvalues_of_the_vehicle() {
    let mount = |damping: f64| {
        format!(
            "{{name=\"mount\",kind=\"bushing\",from=\"car\",to=\"box\",at=[0.5,0,1],stiffness=[4e6,4e6,2.274e6],damping=[3e3,3e3,{damping}],rotational_stiffness=[1e6,1e6,1e6],rotational_damping=[300,300,300],preload=[0,0,-3924]}}"
        )
    };
    let series = ",{name=\"series\",kind=\"maxwell_damper\",from={body=\"car\",at=[0.5,0,0.5]},to={body=\"box\",at=[0.5,0,1]},axis=\"z\",damping=6e3,stiffness=8e5}";
    for elements in [mount(60.0), mount(6e3), mount(0.0) + series] {
        let changes = [
            "vehicle.body=[{name=\"box\",mass=400,inertia_xx=20,inertia_yy=20,inertia_zz=20,position=[0.5,0,1]}]".to_string(),
            format!("vehicle.force=[{elements}]"),
        ];
        let scene = load::open("bogie", &changes).unwrap_or_else(|error| panic!("{error}"));
        let (system, wheelsets) = parts(&scene.vehicle, 0.0).unwrap();
        let mut carried = Carried::new(&system, wheelsets.len(), &design(&scene.vehicle, &system));
        let groups = carried.groups();
        assert_eq!(groups.len(), 1, "{groups:?}");
        let found = carried.modes(&groups[0]);
        let own_height = 6 * (system.bodies.iter().position(|body| body.name == "box").unwrap() - wheelsets.len()) + 2;
        let box_height = |shape: &nalgebra::DVector<f64>| shape[own_height].abs() / shape.amax();
        let bounce = (0..found.len()).filter(|i| box_height(&found[*i].shape) > 0.99 && found[*i].value > 1e3).collect::<Vec<_>>();
        assert_eq!(bounce.len(), 1, "{bounce:?}");
        let swing = carried.swings(&found)[bounce[0]].unwrap();
        let (rate, damping) = (swing.rate, swing.damping);
        let all = modes(&scene, scene.vehicle.speed).unwrap();
        let near = |mode: &&wheelrail::study::modes::Mode| (10.0..16.0).contains(&mode.frequency) && mode.name.contains("box");
        let own = all.modes.iter().find(near).unwrap();
        let value = (std::f64::consts::TAU * own.frequency).hypot(own.growth);
        println!("{rate:.3} 1/s for {value:.3}, {damping:.5} for {:.5}", -own.growth / value);
        // What a damper in series does is looked at on the circle through the undamped rate: 8 % off here.
        assert!((rate / value - 1.0).abs() < 0.01 && (damping * value / -own.growth - 1.0).abs() < 0.1);
    }
}
