#!/usr/bin/env bash
# Makes the pictures and measured parts of docs/ anew from runs of this checkout: an hour, on a machine that does nothing else. Words are edited in the pages
# themselves; docs/renew.py PAGE makes one page's parts. docs/accuracy.sh makes docs/accuracy.md.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
./target/release/wheelrail run suspended_wheelset --plot docs/images >/dev/null
./target/release/wheelrail run vehicle_curve --plot docs/images >/dev/null
rm docs/images/suspended_wheelset_{forces,accelerations,contacts,spectra}.svg # what no page shows
WHEELRAIL_BLESS=1 cargo test --release --test prop docs_list >/dev/null
python3 docs/renew.py docs/{formulations_compared,performance,evidence,contact_geometry,paper_vehicle,creep_laws,real_profiles,modes,effects,assess,sweep}.md
for file in docs/images/vehicle_*.svg; do # what no page shows
    grep -qF "images/$(basename "$file")" docs/paper_vehicle.md docs/accuracy.md docs/runs.md || rm "$file"
done
for example in anti_slip wheel_slide bridge energy_balance; do # numbers of docs/examples.md are those that these print; fmpy and pythonfmu must be there
    python3 "examples/$example.py" -o "docs/images/example_$example.svg"
done
random=$(sed -n '/^## Random scenes/,$p' docs/hard_cases.md) # 10 000 scenes take an hour: `wheelrail hard --random 10000 --seed N`
./target/release/wheelrail hard --markdown docs/hard_cases.md >/dev/null 2>&1 || true # says itself what is broken
printf '\n%s\n' "$random" >>docs/hard_cases.md
