#!/usr/bin/env python3
"""Writes fmu/licenses/third_party.txt anew: docs/licenses.py   (needs the package registry, for the crates of other platforms)

The file goes into every FMU (documentation/licenses/): crates whose code the FMU's library holds on any of the platforms below, their licenses' texts, and at the end the crates of
Cargo.lock that it does not hold. tests/prop/licenses.rs compares it with Cargo.lock. Where a crate may be had under the MIT license, that is the one that is taken.
"""

import json
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLATFORMS = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-gnu", "x86_64-apple-darwin", "aarch64-apple-darwin"]
MIT = (
    'Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation files (the "Software"), to deal in the '
    "Software without restriction, including without limitation the rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, "
    "and to permit persons to whom the Software is furnished to do so, subject to the following conditions:\n\nThe above copyright notice and this permission notice shall be "
    'included in all copies or substantial portions of the Software.\n\nTHE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT '
    "LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY "
    "CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER "
    "DEALINGS IN THE SOFTWARE."
)


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def linked():
    found = set()
    for platform in PLATFORMS:
        tree = cargo("tree", "--locked", "-e", "normal,no-proc-macro", "--no-default-features", "--target", platform, "--prefix", "none", "--format", "{p}")
        found |= {tuple(line.split()[:2]) for line in tree.splitlines() if line}
    return {(name, version.removeprefix("v")) for name, version in found if name != "wheelrail"}


def texts(package):
    """The license files of a crate, those of the MIT license alone where it is one of several to choose from; parts of other origin have files of their own."""
    folder = Path(package["manifest_path"]).parent
    files = sorted(file for file in folder.iterdir() if file.is_file() and re.match(r"(licen[sc]e|copying|notice|unlicense|copyright)", file.name, re.I))
    expression = package["license"] or ""
    if "MIT" in expression and re.search(r" OR |/", expression) and " AND " not in expression:
        mine = [file for file in files if "mit" in file.name.lower()]
        if mine:
            files = mine + [file for file in files if re.match(r"notice", file.name, re.I)]
    found = [file.read_text(errors="replace").replace("\r", "").strip() for file in files]
    if not any("Permission is hereby granted" in text for text in found) and "MIT" in expression and not any("Apache License" in text for text in found):
        holders = ", ".join(re.sub(r" *<.*?>", "", author) for author in package["authors"]) or f"the authors of {package['name']}"
        found.insert(0, f"MIT License\n\nCopyright (c) {holders}\n\n{MIT}")
    assert found, f"{package['name']}: no license text"
    return found


def main():
    packages = {(package["name"], package["version"]): package for package in json.loads(cargo("metadata", "--locked", "--format-version", "1"))["packages"]}
    used = sorted(linked())
    by_text = {}
    for key in used:
        for text in texts(packages[key]):
            by_text.setdefault(re.sub(r"\s+", " ", text), (text, []))[1].append(" ".join(key))
    lines = [
        "Software in this FMU's library beside wheelrail itself, with its licenses.",
        "",
        "Rust's standard library (the Rust project's contributors; MIT OR Apache-2.0, taken under the MIT license, whose text stands below)",
    ]
    lines += [f"{name} {version}: {packages[name, version]['license']}" for name, version in used]
    for text, owners in sorted(by_text.values(), key=lambda entry: entry[1]):
        lines += ["", "=" * 80, ", ".join(owners), "-" * 80, text]
    lines += ["", "=" * 80, f"Rust's standard library\n{'-' * 80}\nMIT License\n\nCopyright (c) the Rust project's contributors\n\n{MIT}"]
    lock = re.findall(r'name = "(.*)"\nversion = "(.*)"', (ROOT / "Cargo.lock").read_text())
    others = sorted({" ".join(key) for key in lock} - {" ".join(key) for key in used} - {f"wheelrail {packages_version(packages)}"})
    lines += ["", "=" * 80, "Not in the library: programs, tests, compilers' helpers and other platforms of this version use", "-" * 80, *others, ""]
    target = ROOT / "fmu/licenses/third_party.txt"
    target.write_text("\n".join(line.rstrip() for line in "\n".join(lines).split("\n")))
    print(f"{target.relative_to(ROOT)}: {len(used)} crates, {len(by_text)} texts, {target.stat().st_size // 1000} kB")


def packages_version(packages):
    return next(version for name, version in packages if name == "wheelrail")


main()
