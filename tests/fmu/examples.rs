//! The examples that couple a vehicle with other models: each runs as a user would run it, shorter, and judges its own numbers against formulas.

use super::{ROOT, python, run, scratch};
use std::path::Path;
use std::process::Command;

fn example(name: &str, arguments: &[&str]) {
    let picture = scratch().join(format!("{name}.svg"));
    let _ = std::fs::remove_file(&picture);
    let mut command = Command::new(python());
    command.arg("-B").arg(Path::new(ROOT).join("examples").join(format!("{name}.py"))).args(arguments).arg("-o").arg(&picture);
    let text = run(command.env("WHEELRAIL", env!("CARGO_BIN_EXE_wheelrail")));
    println!("{text}");
    let checks = text.lines().filter(|line| line.starts_with("ok ")).count();
    assert!(checks >= 2 && text.lines().last() == Some("0 failed"), "{text}");
    assert!(std::fs::read_to_string(&picture).unwrap().contains("<polyline"));
}

#[test]
fn fmu_example_of_anti_slip_control_of_a_locomotive() {
    example("anti_slip", &["--short"]);
    example("anti_slip", &["--short", "--step", "0.002", "--seed", "7"]);
}

#[test]
fn fmu_example_of_wheel_slide_protection() {
    example("wheel_slide", &["--short"]);
}

#[test]
fn fmu_example_of_a_bridge_under_a_coach() {
    example("bridge", &["--short"]);
}

#[test]
fn fmu_example_of_a_train_s_energy_balance() {
    example("energy_balance", &["--short"]);
}
