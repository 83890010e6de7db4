//! The program as a user meets it: output, messages, exit codes.

use std::process::{Command, Output};

fn wheelrail(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).current_dir(env!("CARGO_TARGET_TMPDIR")).output().unwrap()
}

fn text(output: &Output) -> (String, String, i32) {
    let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (read(&output.stdout), read(&output.stderr), output.status.code().unwrap())
}

#[test]
fn prop_run_prints_a_summary_and_writes_csv_and_svg() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, plots) = (folder.path().join("r.csv"), folder.path().join("plots"));
    let output = wheelrail(&["run", "suspended_wheelset", "--stop", "1", "-o", csv.to_str().unwrap(), "--plot", plots.to_str().unwrap()]);
    let (stdout, stderr, code) = text(&output);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("lateral displacement [mm]") && stdout.contains("1 s simulated"), "{stdout}");
    let written = std::fs::read_to_string(&csv).unwrap();
    let mut lines = written.lines();
    let header = lines.next().unwrap();
    assert!(header.starts_with("time [s],wheelset.distance [m],wheelset.y [m]"), "{header}");
    assert_eq!(lines.count(), 401);
    let pictures: [(&str, &[&str]); 5] = [
        ("", &["Lateral displacement", "Yaw", "Wheel loads", "distance [m]", "left wheel", "Rails, lateral displacement", "<polyline"]),
        ("_forces", &["Lateral forces", "Y/Q [-], outward positive", "sum of Y [kN]"]),
        ("_accelerations", &["Lateral acceleration, wheelsets", "az [m/s2], wheelsets"]),
        ("_contacts", &["Left rail", "Right wheel", "contact 1", "<polygon"]),
        ("_spectra", &["density [(m/s2)2/Hz], wheelsets", "frequency [Hz]", "Welch, Hann, 100 samples"]),
    ];
    for (key, words) in pictures {
        let svg = std::fs::read_to_string(plots.join(format!("suspended_wheelset{key}.svg"))).unwrap();
        for word in words {
            assert!(svg.contains(word), "{key}: {word}");
        }
    }
    // Another run over it.
    let against =
        |more: &[&str]| text(&wheelrail(&[&["run", "vehicle_curve", "--stop", "0.4", "--plot", plots.to_str().unwrap()], more].concat()));
    let other = folder.path().join("other.csv");
    assert_eq!(against(&["-o", other.to_str().unwrap()]).2, 0);
    let (_, stderr, code) = against(&["--set", "contact.friction=0.2", "--against", other.to_str().unwrap()]);
    assert_eq!(code, 0, "{stderr}");
    for key in ["", "_forces", "_bodies"] {
        let svg = std::fs::read_to_string(plots.join(format!("vehicle_curve{key}.svg"))).unwrap();
        assert_eq!(svg.matches("other.csv").count(), 1, "{key}: once in the legend");
    }
    let (_, stderr, code) = against(&["--against", csv.to_str().unwrap()]);
    assert!(code == 2 && stderr.contains("no distance of a part of this scene, such as "), "{stderr}");
}

#[test]
fn prop_zero_length_run_gives_the_initial_state() {
    let (stdout, _, code) = text(&wheelrail(&["run", "suspended_wheelset", "--stop", "0", "-o", "-"]));
    assert_eq!(code, 0);
    assert_eq!(stdout.lines().count(), 2, "header and one row");
}

#[test]
fn equiv_times_with_and_without_units() {
    let run = |stop: &str, step: &str| {
        let (stdout, stderr, code) = text(&wheelrail(&["run", "suspended_wheelset", "--stop", stop, "--step", step, "-o", "-"]));
        assert_eq!(code, 0, "{stderr}");
        stdout
    };
    assert_eq!(run("0.1", "0.004"), run("100 ms", "4 ms"));
}

#[test]
fn prop_set_keeps_words_that_look_like_numbers() {
    // 60e1 is a rail; as a number it would be 600.
    let arguments = ["plan", "wheelset_s1002", "--set", "track.rail.kind=60e1", "--set", "track.inclination=0.025"];
    let (_, stderr, code) = text(&wheelrail(&arguments));
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn prop_json_is_json() {
    for arguments in
        [&["run", "suspended_wheelset", "--stop", "0.1", "--json"][..], &["plan", "suspended_wheelset", "--json"], &["list", "--json"]]
    {
        let (stdout, stderr, code) = text(&wheelrail(arguments));
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<serde_json::Value>(&stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}\n{stdout}"));
    }
}

/// The formulations that `wheelrail list` names.
fn formulations() -> Vec<String> {
    let (stdout, _, _) = text(&wheelrail(&["list", "formulations", "--json"]));
    let list: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    list["formulations"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap().to_string()).collect()
}

#[test]
fn prop_compare_prints_every_formulation_and_draws_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("new/pictures");
    let arguments = ["compare", "suspended_wheelset", "--stop", "0.6", "--set", "contact.formulation=ECF-A", "-o"];
    let (stdout, stderr, code) = text(&wheelrail(&[&arguments[..], &[pictures.to_str().unwrap()]].concat()));
    assert_eq!(code, 0, "{stderr}");
    let names = formulations();
    let head = stdout.lines().find(|line| line.split_whitespace().eq(names.iter().map(String::as_str)));
    assert!(head.is_some() && names.len() >= 3, "a column of costs for each formulation:\n{stdout}");
    for words in
        ["CPU time per simulated second [ms]", "ACCF against ECCF (numerical)", "ECF-A against ECCF (models)", "solver.tolerance = 1e-10"]
    {
        assert!(stdout.contains(words), "{words}:\n{stdout}");
    }
    assert!(!stdout.contains("FAILED"), "{stdout}");
    for quantity in ["lateral_displacement", "yaw", "normal_force_right", "normal_force_left"] {
        for pair in ["ACCF_ECCF", "ECF-A_ECF-N", "ECF-A_ECCF"] {
            let svg = std::fs::read_to_string(pictures.join(format!("suspended_wheelset_{quantity}_{pair}.svg"))).unwrap();
            for word in pair.split('_').chain(["distance [m]", "difference [", "<polyline"]) {
                assert!(svg.contains(word), "{quantity} {pair}: {word}");
            }
        }
    }
    assert_eq!(stderr.lines().count(), std::fs::read_dir(&pictures).unwrap().count(), "one message per picture, no progress bar: {stderr}");
}

/// Two rigid formulations agree to the error of their integration; a rigid and an elastic one differ by the elastic wheel's
/// sinking into the rail, about 0.07 mm.
#[test]
fn prop_compare_as_json_tells_models_from_numerics() {
    let folder = tempfile::tempdir().unwrap();
    let (stdout, stderr, code) = text(&wheelrail(&[
        "compare",
        "suspended_wheelset",
        "--stop",
        "0.6",
        "--step",
        "0.01",
        "--json",
        "-o",
        folder.path().to_str().unwrap(),
    ]));
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{error}\n{stdout}"));
    let names: Vec<&str> = found["formulations"].as_array().unwrap().iter().map(|run| run["name"].as_str().unwrap()).collect();
    assert_eq!(names, formulations());
    for run in found["formulations"].as_array().unwrap() {
        assert!(run["error"].is_null() && run["cost"]["cpu_seconds"].as_array().unwrap().len() == 3, "{run}");
        assert!(run["cost"]["statistics"]["evaluations"].as_u64().unwrap() > 100, "{run}");
    }
    let height = |first: &str, second: &str| {
        let pairs = found["differences"].as_array().unwrap();
        let pair = pairs.iter().find(|pair| pair["first"] == first && pair["second"] == second).unwrap();
        pair["quantities"]["height"]["largest"].as_f64().unwrap()
    };
    let (numerical, models) = (height("ACCF", "ECCF"), height("ECF-A", "ECCF"));
    println!("largest difference in height: {numerical:.1e} m between rigid ones, {models:.1e} m between elastic and rigid");
    assert!(numerical < 1e-8 && (3e-5..2e-4).contains(&models), "{numerical} {models}");
}

/// Behind a short bump rigid formulations, told to stop at lift-off, can't go on; elastic ones can.
#[test]
fn hard_compare_goes_on_without_formulations_that_fail() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().to_str().unwrap();
    let compare = |stop: &str, changes: &[&str]| {
        let fixed = ["compare", "suspended_wheelset", "--step", "0.01", "-o", folder, "--set", "contact.on_lift=stop", "--stop", stop];
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", *change]).collect();
        text(&wheelrail(&[&fixed[..], &changes].concat()))
    };
    let bump = ["track.deviation[1].direction=vertical", "track.deviation[1].to=22 m", "track.deviation[1].amplitude=10 mm"];
    let (stdout, stderr, code) = compare("0.6", &bump);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("FAILED: t = ") && stdout.contains("lifts off"), "{stdout}");
    // What it did until then is compared and drawn; costs are those of the others.
    assert!(stdout.contains("ECF-A against ECCF (models)") && stderr.contains("_ECF-A_ECCF.svg"), "{stdout}{stderr}");
    let costs = stdout.lines().skip_while(|line| !line.starts_with("Cost")).nth(2).unwrap();
    assert!(costs.contains("ECF-A") && !costs.contains("ECCF"), "{stdout}");
    // A wheelset beside its rails is nothing that any formulation can begin with.
    let (stdout, stderr, code) = compare("0.1", &["vehicle.initial.y=2"]);
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(stdout.matches("FAILED").count() == formulations().len(), "{stdout}");
    assert!(stderr.contains("no formulation ran to the end"), "{stderr}");
}

#[test]
fn prop_bad_input_is_exit_code_2_with_a_sentence_that_helps() {
    let cases: &[(&[&str], &str)] = &[
        (&["run", "suspended_wheelsets"], "did you mean \"suspended_wheelset\"?"),
        (&["run", "suspended_wheelset", "--set", "vehicle.sped=30"], "suspended_wheelset.toml:"),
        (&["run", "suspended_wheelset", "--set", "vehicle.sped=30"], "did you mean \"speed\"?"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed=3 deg"], "expected a number in m/s; a string may carry"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed=0"], "creepages are relative"),
        (&["run", "suspended_wheelset", "--set", "vehicle.speed"], "expected key=value"),
        (&["run", "suspended_wheelset", "--set", "contact.creep.law=fastsimm"], "shen_hedrick_elkins"),
        (&["run", "suspended_wheelset", "--set", "track.deviation[2].rail=left"], "1 entries"),
        (&["run", "suspended_wheelset", "--set", "vehicle.wheelset.inertia_zz=1"], "body of revolution"),
        (&["run", "suspended_wheelset", "--step", "0"], "--step 0"),
        (&["run", "suspended_wheelset", "--step", "4 mm"], "expected a number in s; a string may carry ms, us"),
        (&["run", "suspended_wheelset", "-o", "no/such/folder/x.csv"], "there is no folder no/such/folder; make the folder first"),
        (&["run", "suspended_wheelset", "--stop", "-1"], "--stop"),
        (&["compare", "suspended_wheelsets"], "did you mean \"suspended_wheelset\"?"),
        (&["compare", "suspended_wheelset", "--set", "vehicle.sped=30"], "did you mean \"speed\"?"),
        (&["compare", "suspended_wheelset", "--stop", "0"], "nothing to compare"),
        (&["compare", "suspended_wheelset", "-o", env!("CARGO_MANIFEST_PATH")], "can't be made"),
        (&["list", "creep-law"], "did you mean \"creep-laws\"?"),
        (&["export", "suspended_wheelset", "-o", "/no/such/folder/x.fmu"], "can't be written"),
        (&["export", "suspended_wheelset", "--library", env!("CARGO_MANIFEST_PATH")], "not an FMU library of wheelrail"),
    ];
    for (arguments, sentence) in cases {
        let (stdout, stderr, code) = text(&wheelrail(arguments));
        assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
        assert!(stderr.contains(sentence), "{arguments:?} said: {stderr}");
        assert!(stdout.is_empty(), "messages belong to stderr");
    }
}

#[test]
fn prop_a_library_of_another_build_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("other.so");
    std::fs::write(&file, b"...wheelrail-build-id:000000000000000000000000:...").unwrap();
    let (_, stderr, code) = text(&wheelrail(&["export", "suspended_wheelset", "--library", file.to_str().unwrap()]));
    assert_eq!(code, 2);
    assert!(stderr.contains("other sources") && stderr.contains("CONTRIBUTING.md"), "{stderr}");
}

#[test]
fn hard_a_failing_run_is_exit_code_1_and_keeps_its_rows() {
    // Thrown sideways on a slippery rail, a cone without flange leaves its profile.
    let (stdout, stderr, code) = text(&wheelrail(&[
        "run",
        "suspended_wheelset",
        "-o",
        "-",
        "--stop",
        "2",
        "--set",
        "vehicle.initial.vy=2.5",
        "--set",
        "contact.friction=0.01",
    ]));
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("wheelset") && stderr.contains("t = "), "{stderr}");
    assert!(stdout.lines().count() > 2, "what was computed is written: {}", stdout.lines().count());
}

/// A line of the plan with a blank for the share of the time.
fn without_share(line: &str) -> String {
    let Some(end) = line.find(" %  ") else { return line.into() };
    let begin = line[..end].rfind(' ').map_or(0, |place| place + 1);
    format!("{}{}{}", &line[..begin], " ".repeat(end + 2 - begin), &line[end + 2..])
}

#[test]
fn regress_plan_of_each_embedded_scene() {
    for scene in wheelrail::scene::embedded::SCENES {
        let (stdout, stderr, code) = text(&wheelrail(&["plan", scene.name]));
        assert_eq!(code, 0, "{stderr}");
        let (plan, costs) = stdout.split_once("\nOne evaluation").unwrap();
        // Shares are measured: they have their place, but no number.
        let shares = plan.lines().filter(|line| without_share(line) != **line).count();
        assert!(shares >= 4, "contact, normal force, creep forces, bodies: {plan}");
        let plan: Vec<String> = plan.lines().map(without_share).collect();
        insta::assert_snapshot!(format!("plan_{}", scene.name), plan.join("\n").trim_end());
        assert!(costs.contains("%  contact search"), "{stdout}");
    }
}

#[test]
fn prop_plan_says_what_is_there_and_why() {
    let line = |effect: &str, changes: &[&str]| {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", *change]).collect();
        let (stdout, stderr, code) =
            text(&wheelrail(&[&["plan", "wheelset_s1002", "--set", "vehicle.initial.y=0"][..], &changes].concat()));
        assert_eq!(code, 0, "{stderr}");
        stdout.lines().find(|line| line.contains(effect)).unwrap_or_else(|| panic!("no {effect}:\n{stdout}")).to_string()
    };
    let cone = "vehicle.wheelset.profile={ kind = \"cone\", radius = 0.46, slope = 0.025 }";
    let arc = "track.rail={ kind = \"arc\", radius = 0.3 }";
    let left_cone = "vehicle.wheelset.left_profile={ kind = \"cone\", radius = 0.46, slope = 0.025 }";
    let left_arc = "track.left_rail={ kind = \"arc\", radius = 0.3 }";
    let ellipse = "contact.patch=ellipse";
    let cases: &[(&str, &[&str], bool, &str)] = &[
        ("non-elliptic patches", &[], true, "\"auto\" is strips"),
        ("non-elliptic patches", &["contact.formulation=ACCF"], false, "\"auto\" is ellipse: constraints"),
        ("non-elliptic patches", &["contact.normal={ law = \"hertz\" }"], false, "[contact.normal] is the law of an ellipse"),
        ("non-elliptic patches", &["effects.spin=off"], false, "effects.spin = \"off\""),
        ("non-elliptic patches", &["contact.patch=strips"], true, "contact.patch = \"strips\""),
        ("several contacts", &[], true, "contact.patch = \"strips\": parts of patches"),
        ("several contacts", &[ellipse], true, "as many as these profiles can need, 2: searched for"),
        ("several contacts", &["contact.points=3"], true, "contact.points = 3: searched for"),
        ("several contacts", &["contact.points=1"], false, "contact.points = 1"),
        ("several contacts", &[cone, arc, ellipse], false, "strictly convex"),
        ("several contacts", &[left_cone, left_arc, ellipse], true, "searched for on the right; on the left only one place"),
        ("longitudinal force input", &[], false, "imposed speed leaves no room"),
        ("longitudinal force input", &["vehicle.travel=free"], true, "vehicle.travel = \"free\""),
        ("longitudinal force input", &["vehicle.travel=free", "interface.inputs=[]"], false, "lacks \"centre_forces\""),
        ("grade", &[], false, "no track.grade"),
        ("grade", &["track.grade=0.02"], true, "track.grade = 2.00 %"),
        ("contact damping", &["contact.formulation=ECCF"], true, "contacts beside the first"),
        ("contact damping", &["contact.formulation=ECCF", "contact.points=1"], false, "wheel that has lifted"),
        ("transient tangential", &["contact.transient={ below = \"2 m/s\" }"], true, "below = 2 m/s"),
    ];
    for (effect, changes, included, words) in cases {
        let line = line(effect, changes);
        let marks = if *included { &["  in ", "  guarded "][..] } else { &["  out"] };
        assert!(marks.iter().any(|mark| line.starts_with(mark)) && line.contains(words), "{changes:?}: {line}");
    }
    // What waits says for what; where everything is computed all the same, nothing waits.
    let transient = "contact.transient={ below = \"2 m/s\" }";
    let curve = "track.node=[{distance=500},{distance=560,radius=600}]";
    for (effect, change, words) in [
        ("transient tangential", transient, "stand still above 4 m/s"),
        ("curves", curve, "from s = 500.0 m on"),
        ("left rail deviations", "track.start_fade=5", "from s = 10.0 m on"),
        ("several contacts", ellipse, "certificate"),
    ] {
        let [waits, acts] = [line(effect, &[change]), line(effect, &[change, "effects.mode=all"])];
        assert!(waits.starts_with("  guarded ") && waits.contains(words), "{waits}");
        assert!(acts.starts_with("  in "), "{acts}");
    }
}

/// A measured profile's datum that the scene does not give is assumed, and said.
#[test]
fn prop_plan_tells_what_was_assumed_in_reading_profiles() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let embedded = wheelrail::scene::embedded::find("wheelset_s1002").unwrap().text;
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/profiles/rail_60e1.prr"), folder.path().join("rail.prr")).unwrap();
    std::fs::write(&scene, embedded.replace("kind = \"60e1\"", "kind = \"simpack\"\nfile = \"rail.prr\"")).unwrap();
    let (stdout, stderr, code) = text(&wheelrail(&["plan", scene.to_str().unwrap()]));
    assert_eq!(code, 0, "{stderr}");
    let notes: Vec<&str> = stdout.lines().filter(|line| line.starts_with("  note: ")).collect();
    assert!(!notes.is_empty() && notes.iter().all(|note| note.contains("left rail profile")), "each note once: {stdout}");
}

#[test]
fn prop_creep_force_table_does_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let written = ["1", "3"].map(|threads| {
        let file = folder.path().join(threads);
        let output = Command::new(env!("CARGO_BIN_EXE_wheelrail"))
            .args(["table", "--grid", "8", "--steps", "4", "--shapes", "4", "-o", file.to_str().unwrap()])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output).1);
        std::fs::read(&file).unwrap()
    });
    assert!(written[0].len() > 5000 && written[0] == written[1]);
    let (_, stderr, code) = text(&wheelrail(&["table", "--grid", "9", "-o", "x"]));
    assert!(code == 2 && stderr.contains("--grid 9: expected an even number"), "{stderr}");
}

/// docs/names.md is the list of everything a scene can name; `WHEELRAIL_BLESS=1 cargo test` writes it anew.
#[test]
fn regress_docs_list_every_name() {
    let (stdout, _, _) = text(&wheelrail(&["list"]));
    let page = format!(
        "# What a scene can name\n\nThe output of `wheelrail list`, made from the program's registries.\n\n```text\n{}```\n",
        stdout
    );
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/names.md");
    if std::env::var_os("WHEELRAIL_BLESS").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap_or_default(), page, "run WHEELRAIL_BLESS=1 cargo test docs_list");
}

/// Registries have one shape: names that a scene can write, each once, and a line that says what it is.
#[test]
fn prop_every_registry_lists_names_with_a_summary() {
    let (stdout, _, _) = text(&wheelrail(&["list", "--json"]));
    let kinds: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&stdout).unwrap();
    for wanted in ["templates", "joints", "forces", "profiles", "formulations", "creep-laws", "integrators"] {
        assert!(kinds.contains_key(wanted), "{wanted} is not listed");
    }
    for (kind, rows) in &kinds {
        let rows = rows.as_array().unwrap();
        let word = |row: &serde_json::Value, key: &str| row[key].as_str().unwrap().to_string();
        let mut names: Vec<String> = rows.iter().map(|row| word(row, "name")).collect();
        let summaries: Vec<String> = rows.iter().map(|row| word(row, "summary")).collect();
        names.sort();
        assert!(!names.is_empty() && names.windows(2).all(|pair| pair[0] != pair[1]), "{kind}: {names:?}");
        assert!(summaries.iter().all(|summary| !summary.is_empty() && !summary.contains('\n')), "{kind}: {summaries:?}");
    }
}

/// docs/outputs.md has every output with its sign: those of one wheelset, its left wheel and first contact, one body, one sensor, each kind of element.
#[test]
fn regress_docs_list_every_output() {
    use wheelrail::scene::load;
    use wheelrail::sim::Simulation;
    use wheelrail::sim::energy::VEHICLE;
    use wheelrail::sim::vehicle_outputs::{BODY, FORCE, SENSOR, scene_outputs};
    let groups = "interface.outputs=[\"motion\",\"wheels\",\"contacts\",\"suspension\",\"sliding_means\",\"rail_forces\",\"axles\",\"bodies\",\"sensors\",\"forces\",\"adhesion\",\"power\",\"energy\"]";
    let mut lines: Vec<String> = Vec::new();
    let examples = ["examples/braked_coach.toml", "examples/driven_truck.toml"];
    let embedded = ["wheelset_s1002", "vehicle_bumps", "vehicle_manchester_1", "train"];
    let plain = embedded.into_iter().chain(examples).map(|name| (name, "interface.inputs=[\"rail_motion\"]"));
    // What some scenes alone have.
    let special = [
        ("vehicle_manchester_1", "vehicle.detail=truck"),
        ("vehicle_manchester_1", "vehicle.sensor=[{name=\"floor[1]\", measured=true}]"),
        ("bogie", "track.flexibility=travelling"),
        ("examples/scenes/freight_wagon_wedges.toml", "vehicle.speed=20"),
        ("bogie", "vehicle.force=[{name=\"axle\", kind=\"flexible_axle\", body=\"wheelset[1]\", stiffness=1e6}]"),
    ];
    for (name, change) in plain.chain(special) {
        let scene = load::open(name, &[groups.into(), change.into()]).unwrap_or_else(|error| panic!("{error}"));
        let simulation = Simulation::new(&scene, 0.0).unwrap();
        let wheelset = &simulation.model().wheelsets[0].name;
        for output in scene_outputs(&scene, simulation.model()) {
            let last = output.name.rsplit('.').next().unwrap_or_default();
            let shown = match output.reference {
                r if r >= VEHICLE => output.name.clone(),
                r if r >= SENSOR => format!("S.{last}"),
                r if r >= FORCE => format!("F.{last}"),
                r if r >= BODY => format!("B.{last}"),
                r if r / 1000 == 1 && !(140..300).contains(&(r % 1000)) => output.name.replacen(wheelset.as_str(), "W", 1),
                _ => continue,
            };
            let text = output.description.replace('|', "\\|");
            let line = format!("| `{shown}` | {} | {} | {text} |\n", output.unit.name(), output.group);
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    let page = format!(
        "# Outputs\n\nEvery output of the FMU and column of `wheelrail run -o`, made from the program's table. W is a wheelset, B a body, S a sensor, F a force element of the scene; \
         the right wheel has the same outputs as the left one, and every contact those of `contact[1]`. X is forward, Y to the left, Z up. Files of results: [runs.md](runs.md).\n\n\
         | output | unit | group | meaning and sign |\n|---|---|---|---|\n{}",
        lines.concat()
    );
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/outputs.md");
    if std::env::var_os("WHEELRAIL_BLESS").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap_or_default(), page, "run WHEELRAIL_BLESS=1 cargo test docs_list");
}

#[test]
fn equiv_profile_written_as_csv_reads_back_as_itself() {
    use wheelrail::geometry::profile::{self, Part, Profile};
    use wheelrail::settings::{Section, Source};
    let folder = tempfile::tempdir().unwrap();
    let read = |settings: &str, part: Part| -> std::sync::Arc<dyn Profile> {
        let text = format!("profile = {settings}\n");
        let source = Source { file: "t".into(), text: text.clone(), overridden: vec![], folder: Some(folder.path().into()) };
        let document = toml_edit::Document::parse(text).unwrap();
        profile::parse(Section::root(document.as_table(), &source).section("profile").unwrap(), part).unwrap().profile
    };
    for (settings, part, word) in [("{ kind = \"s1002\", radius = 0.46 }", Part::Wheel, "S1002"), ("60e1", Part::Rail, "60E1")] {
        let (csv, svg) = (folder.path().join("p.csv"), folder.path().join("p.svg"));
        let files = ["--points", "1001", "-o", csv.to_str().unwrap(), "--plot", svg.to_str().unwrap()];
        let (stdout, stderr, code) = text(&wheelrail(&[&["profile", settings][..], &files].concat()));
        assert_eq!(code, 0, "{stderr}");
        assert!(stdout.contains(word) && stdout.contains("curvature [1/m]"), "{stdout}");
        let drawn = std::fs::read_to_string(&svg).unwrap();
        assert!(["outward", "curvature [1/m]", "<polyline"].iter().all(|word| drawn.contains(word)));
        let wanted = read(if part == Part::Wheel { settings } else { "{ kind = \"60e1\" }" }, part);
        let found = read("{ kind = \"points\", file = \"p.csv\" }", part);
        assert_eq!(found.range(), wanted.range());
        let (first, last) = wanted.range();
        let mut largest = 0.0f64;
        for i in 0..5000 {
            let x = first + (last - first) * (f64::from(i) + 0.5) / 5000.0;
            let (a, b) = (found.at(x), wanted.at(x));
            largest = largest.max((a.value - b.value).abs() / (1.0 + b.d1 * b.d1).sqrt());
        }
        println!("{word}: largest distance {:.3} um", 1e6 * largest);
        assert!(largest < 2e-6);
        for row in std::fs::read_to_string(&csv).unwrap().lines().skip(1) {
            let n: Vec<f64> = row.split(',').map(|word| word.parse().unwrap()).collect();
            assert_eq!((n[1], n[2]), (wanted.at(n[0]).value, wanted.at(n[0]).d1), "exact at the points");
        }
        let (bare, _, _) = text(&wheelrail(&["profile", csv.to_str().unwrap(), "--bare", "--points", "11", "-o", "-"]));
        assert_eq!(bare.lines().count(), 12, "{bare}");
        assert!(bare.lines().all(|line| line.matches(',').count() == 1));
    }
    let (_, stderr, code) = text(&wheelrail(&["profile", "60e3"]));
    assert!(code == 2 && stderr.contains("profile.kind: found \"60e3\" (did you mean \"60e"), "{stderr}");
    let (_, stderr, code) = text(&wheelrail(&["profile", "s1002"]));
    assert!(code == 2 && stderr.contains("profile.radius: is missing"), "{stderr}");
}
