#!/usr/bin/env bash
# Makes docs/accuracy.md and its pictures anew from runs of `wheelrail study`: less than 6 minutes, on a machine that does nothing else.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${WHEELRAIL:-} # a program that is built already
if [ -z "$program" ]; then
    cargo build --release
    program=./target/release/wheelrail
fi
folder=$(mktemp -d)
study() { # heading, words, study's arguments; the CSV's name is that of the scene
    local heading=$1 words=$2
    shift 2
    local name=$1
    for argument in "$@"; do case $argument in name=*) name=${argument#name=} ;; esac done
    printf '## %s\n\n%s\n\n' "$heading" "$words"
    local text
    text=$("$program" study "$@" --plot "$folder" -o "$folder/$name.csv" 2>&1 | grep -v '^wrote ') || true # a refusal is a result
    for quantity in y Q acceleration wavelength; do
        local file="${name}_time_$quantity.svg"
        if [ -e "$folder/$file" ]; then
            mv "$folder/$file" docs/images/
            printf '![Error of %s against CPU time](images/%s)\n\n' "$quantity" "$file"
        fi
    done
    if [ -e "$folder/${name}_best.svg" ] && [ "$name" = suspended_wheelset ]; then
        mv "$folder/${name}_best.svg" "$folder/${name}_communication.svg" "$folder/${name}_work_y.svg" docs/images/
        printf '![Points that no other one beats](images/%s_best.svg)\n\n' "$name"
        printf '![Error of y against evaluations of the right-hand side](images/%s_work_y.svg)\n\n' "$name"
        printf '![Error of y against the communication step](images/%s_communication.svg)\n\n' "$name"
    fi
    printf '    wheelrail study'
    for argument in "$@"; do case $argument in *' '*) printf " '%s'" "$argument" ;; *) printf ' %s' "$argument" ;; esac done
    printf '\n\n```text\n%s\n```\n\n' "$text"
}
{
    cat <<'TEXT'
# What accuracy costs

    wheelrail study SCENE [--formulations ...] [--integrators ...] [--tolerances ...] [--steps ...] [--budget SECONDS] [-o FILE.csv] [--plot DIR]

runs a scene with every formulation, integrator and tolerance (or step), and says what an accuracy costs in time. `wheelrail study --help` has all
options: creep laws, node spacing of ECF-N, smoothing of measured profiles, communication steps.

TEXT
    echo "This page is made by docs/accuracy.sh ($(date +%Y-%m-%d), $(nproc) cores, $(uname -sm), $(rustc --version | cut -d' ' -f1,2)); the command of each section repeats it, -o keeps all"
    echo "points. Times are those of this machine, errors do not depend on it; which points fit into the budget does."
    cat <<'TEXT'

## Rules

- *Same problem, same outputs.* All runs start in the steady state of the same scene and are read at the same output times.
- *Reference.* Rigid contact (ACCF and ECCF) has one, each elastic formulation its own (ECF-N at its node spacing): two independent methods
  (Dormand-Prince 5(4) and the classical method with the error estimate 4(3)) at the same tight tolerance. Their distance is the reference's
  uncertainty. An error below 100 times that is not resolved: hollow marks with an arrow are bounds, and a study without any point above is refused.
  All other integrators tend to the same references, the implicit ones too, whose step formulas share nothing with the two (forces, contact search and events are the same).
- *Errors.* The largest over the run, of lateral displacement, wheel load Q, normal force, Y/Q and a wheelset's accelerations, read every 0.73 ms: a grid
  that no step knows of, between the ends of steps. Where forces jump with the state (places of rigid contacts) what the other run has within one
  sample is no error: a jump may come a little sooner or later (the CSV has rms and 95 % too). Hunting wavelength: mean distance of the upward passages of y through zero between swings of more than
  10 um. Always the worst wheelset or wheel. A sample at which a wheel stands where its rail's curvature jumps is left out.
- *Cost.* CPU time of one thread without reading outputs, one run after the other, median of up to three runs; bars show the spread.
- *Numerical error is not the difference of models.* How far the references of two models are apart is named on its own and drawn as a dashed line:
  beyond it a finer integration does not bring a run nearer to the other model.
- *Failures are results.* A step that is too long, a derailment, a Newton iteration that does not settle are listed with their reason.
- *Budget.* Cheap points first; what is predicted not to fit is left out and counted.

TEXT
    study "Suspended wheelset" "The paper's wheelset over a gauge reduction of 10 mm (section 3.4)." \
        suspended_wheelset --budget 80
    study "Hunting just below the critical speed" "The same wheelset at 65 m/s (assumed). Its motion grows from 66 m/s on and dies out below: a small error of damping is a large one of the motion." \
        suspended_wheelset --set name=hunting --set vehicle.speed=65 --set 'title=Suspended wheelset at 65 m/s, critical speed 66 m/s' --stop 4 --budget 70 --communication-steps none
    study "Vehicle over bumps" "13 bodies, two bumps of 10 mm on both rails (section 5). Vehicle and track are symmetric, y is rounding: normal forces count." \
        vehicle_bumps --stop 1.6 --formulations ECF-A,ECCF --reference 1e-11 --budget 95 --communication-steps none
    study "Vehicle in a curve" "The same vehicle into a curve of 582 m up to flange contact (section 6)." \
        vehicle_curve --stop 2.5 --formulations ECF-A,ECCF --reference 1e-11 --budget 95 --communication-steps none
} >docs/accuracy.md
rm -r "$folder"
