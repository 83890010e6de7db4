#!/usr/bin/env python3
"""Makes the measured parts of pages anew from runs of this checkout: docs/renew.py [PAGE ...]   (all pages of docs/ when none is named)

What stands between <!-- $ COMMAND --> and <!-- / --> is what the command prints (in bash, from the repository's root, with the built program in front of
the path); <!-- $markdown COMMAND --> prints Markdown. Words stand outside and are edited in the page itself. Dates and machines in brackets, such as
(2026-01-31, 2 cores, Linux x86_64, rustc 1.95.0), become those of today in pages of which a part was made anew.
"""

import datetime
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PART = re.compile(r"<!-- \$(markdown)? (.+?) -->\n.*?<!-- / -->", re.DOTALL)
MACHINE = re.compile(r"\(20\d\d-\d\d-\d\d, \d+ cores, [^)]*\)")


def machine():
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True).stdout.split()[:2]
    today = datetime.date.today().isoformat()
    return f"({today}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}, {' '.join(compiler)})"


def made_anew(part):
    kind, command = part.groups()
    print(f"  {command}", file=sys.stderr, flush=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    environment = {**os.environ, "PATH": f"{built}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-c", command], cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    if not done.stdout.strip():
        sys.exit(f"nothing was printed by: {command}")
    text = done.stdout.strip("\n")
    body = text if kind else "```text\n" + text + "\n```"
    return f"<!-- ${kind or ''} {command} -->\n{body}\n<!-- / -->"


for page in [Path(name).resolve() for name in sys.argv[1:]] or sorted((ROOT / "docs").glob("*.md")):
    old = page.read_text()
    if PART.search(old):
        print(page.relative_to(ROOT), file=sys.stderr)
        page.write_text(MACHINE.sub(machine(), PART.sub(made_anew, old)))
