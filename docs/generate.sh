#!/usr/bin/env bash
# Makes the pictures and measured pages of docs/ anew from runs of this checkout.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
./target/release/wheelrail run suspended_wheelset --plot docs/images >/dev/null
WHEELRAIL_BLESS=1 cargo test --release --test cli docs_list >/dev/null
{
    echo "# Accuracy and cost"
    echo
    echo "Printed by \`cargo bench\` ($(date +%Y-%m-%d), $(nproc) cores, $(uname -sm), $(rustc --version | cut -d' ' -f1,2)); made by docs/generate.sh."
    echo "One core is used. Errors are against a run with tolerance 1e-13,"
    echo "which agrees with an independent program to 1e-14 m in that displacement (tests/validate.rs). Aims: a contact below 1 us; 200"
    echo "times real time at 1e-6 m on one core (lines marked * are that exact); the FMU within 10 % of native. The virtual machine used"
    echo "changes its speed by half from minute to minute: compare lines of one run, not runs."
    echo
    echo '```text'
    cargo bench --bench speed 2>/dev/null | grep -vE '^(Benchmarking|Found|  [0-9]+ \(|\s*$|running|test )|Performance has|No change in|Change within|change:'
    echo '```'
    echo
    echo "Where the time of one right-hand side goes (\`wheelrail plan suspended_wheelset\`):"
    echo
    echo '```text'
    ./target/release/wheelrail plan suspended_wheelset | sed -n '/^One evaluation/,$p'
    echo '```'
} >docs/performance.md
