"""Terminals and icons, which FMI 2.0.4 has taken over from FMI 3.0 as they are."""

import os

import fmpy
from lxml import etree


def connections(report, root, files, causalities):
    """Terminals and icons: valid, each member a variable, each input in one terminal, each picture there."""
    schema = etree.XMLSchema(file=os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi3", "fmi3TerminalsAndIcons.xsd"))
    schema.validate(root)
    errors = [f"line {e.line}: {e.message}" for e in schema.error_log]
    report.check(not errors, "schema fmi3TerminalsAndIcons.xsd", "; ".join(errors) or "valid")
    members, bad = [], []
    for terminal in root.iter("Terminal"):
        own = [m.get("memberName") for m in terminal.iter("TerminalMemberVariable")]
        members += [m.get("variableName") for m in terminal.iter("TerminalMemberVariable")]
        icon = terminal.find("TerminalGraphicalRepresentation").get("iconBaseName")
        if len(set(own)) != len(own) or f"terminalsAndIcons/{icon}.png" not in files:
            bad.append(terminal.get("name"))
    names = [terminal.get("name") for terminal in root.iter("Terminal")]
    report.check(not bad and len(set(names)) == len(names) and "terminalsAndIcons/icon.png" in files, "terminals", ", ".join(bad or names))
    inputs = {name for name, causality in causalities.items() if causality == "input"}
    report.check(inputs <= set(members) <= set(causalities) and len(set(members)) == len(members), "each input in one terminal",
                 f"{len(inputs)} inputs, {len(members)} members")
