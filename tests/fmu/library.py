"""library.py LIBRARY [--release] [--glibc VERSION]: what a shared library of an FMU shows and needs.

It exports FMI's functions and nothing else, holds no symbol table, and needs what every machine of its platform has. A library for release also holds no path of the machine that it was built
on, and on Linux needs at most the given glibc. Reads ELF (pyelftools) and PE (pefile); of a Mach-O it looks at paths alone.
"""

import argparse
import os
import pathlib
import re
import sys

EXPORTED = re.compile(r"fmi[23][A-Z][A-Za-z0-9]+")
# Functions that a host can't do without, of each version.
NEEDED = {f"fmi{version}{name}" for version in (2, 3) for name in ("GetVersion", "FreeInstance", "DoStep", "Terminate", "Reset")} \
    | {"fmi2Instantiate", "fmi2GetReal", "fmi2SetReal", "fmi3InstantiateCoSimulation", "fmi3GetFloat64", "fmi3SetFloat64"}
# What Linux has with its C library, and Windows since version 10 for every program.
LINUX = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libgcc_s.so.1", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
WINDOWS = re.compile(r"(kernel32|ntdll|bcryptprimitives|advapi32|userenv|ws2_32|msvcrt|ucrtbase|api-ms-win-[a-z0-9-]+|vcruntime140)\.dll", re.IGNORECASE)
# What the program alone does, which loads libraries to check what it exports: an FMU loads none, and opens no connection. (dlsym looks for what is there: unwinding and Rust's library do. On Windows the latter asks for all functions of sockets.)
LOADERS = {"dlopen", "dlmopen", "LoadLibraryA", "LoadLibraryW", "LoadLibraryExA", "LoadLibraryExW", "FreeLibrary"}
SOCKETS = {"socket", "connect", "bind", "listen", "accept", "accept4", "getaddrinfo"}
# What tells of this machine: the sources' folder, the user's and cargo's. (Rust's own library has sources under /rustc/, which is no machine's.)
PLACES = {str(pathlib.Path(__file__).resolve().parents[2]), str(pathlib.Path.home()), os.environ.get("CARGO_HOME", str(pathlib.Path.home() / ".cargo"))}


def version(text):
    return tuple(int(part) for part in text.split("."))


class Found:
    def __init__(self):
        self.passed = self.failed = 0

    def check(self, holds, what, detail=""):
        self.passed += bool(holds)
        self.failed += not holds
        print(f"  {'ok  ' if holds else 'FAIL'} {what}{': ' if detail else ''}{detail}")

    def imports(self, names, refused, what):
        host = refused & set(names)
        self.check(not host and names, what, ", ".join(sorted(host)) or f"{len(names)} imports")

    def exports(self, names):
        other = sorted(name for name in names if not EXPORTED.fullmatch(name))
        self.check(not other, "exports no symbol but FMI's", ", ".join(other[:9]) or f"{len(names)} functions")
        self.check(NEEDED <= set(names), "exports both versions' functions", ", ".join(sorted(NEEDED - set(names))))


def elf(path, found, limit):
    from elftools.elf.elffile import ELFFile
    with open(path, "rb") as file:
        library = ELFFile(file)
        symbols = [symbol for symbol in library.get_section_by_name(".dynsym").iter_symbols() if symbol.name]
        # Versions' own names stand there as absolute symbols.
        found.exports({s.name for s in symbols if s["st_shndx"] not in ("SHN_UNDEF", "SHN_ABS") and s["st_info"]["bind"] != "STB_LOCAL"})
        found.imports({s.name for s in symbols if s["st_shndx"] == "SHN_UNDEF"}, LOADERS | SOCKETS, "loads no library and opens no connection")
        found.check(library.get_section_by_name(".symtab") is None, "no symbol table beside")
        needed = [tag.needed for tag in library.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")]
        found.check(set(needed) <= LINUX, "needs the C library alone", ", ".join(needed))
        found.check(not list(library.get_section_by_name(".dynamic").iter_tags("DT_RUNPATH")), "looks in no folder of its own")
        versions = {}
        table = library.get_section_by_name(".gnu.version")
        names = {}
        for _, auxiliaries in library.get_section_by_name(".gnu.version_r").iter_versions():
            names.update({auxiliary["vna_other"]: auxiliary.name for auxiliary in auxiliaries})
        for index, symbol in enumerate(library.get_section_by_name(".dynsym").iter_symbols()):
            name = names.get(table.get_symbol(index)["ndx"]) if isinstance(table.get_symbol(index)["ndx"], int) else None
            # A weak symbol may be missing.
            if name and name.startswith("GLIBC_") and symbol["st_info"]["bind"] != "STB_WEAK":
                versions.setdefault(version(name.removeprefix("GLIBC_")), []).append(symbol.name)
        newest = max(versions)
        detail = f"{'.'.join(map(str, newest))} for {', '.join(sorted(versions[newest]))}"
        found.check(limit is None or newest <= version(limit), f"needs glibc {limit or ''} at most".replace("  ", " "), detail)


def pe(path, found):
    import pefile
    library = pefile.PE(path)
    found.exports({symbol.name.decode() for symbol in library.DIRECTORY_ENTRY_EXPORT.symbols if symbol.name})
    found.check(library.FILE_HEADER.PointerToSymbolTable == 0, "no symbol table beside")
    imported = [entry.dll.decode() for entry in library.DIRECTORY_ENTRY_IMPORT]
    found.check(all(WINDOWS.fullmatch(name) for name in imported), "needs Windows' own libraries alone", ", ".join(imported))
    functions = [function for entry in library.DIRECTORY_ENTRY_IMPORT for function in entry.imports]
    found.imports({function.name.decode() for function in functions if function.name}, LOADERS, "loads no library")
    # Two import libraries of one name may leave functions outside of every list that the loader walks: their places hold the address of a name, which a call would jump to.
    table = library.OPTIONAL_HEADER.DATA_DIRECTORY[pefile.DIRECTORY_ENTRY["IMAGE_DIRECTORY_ENTRY_IAT"]]
    listed = {function.address - library.OPTIONAL_HEADER.ImageBase for function in functions}
    words = range(table.VirtualAddress, table.VirtualAddress + table.Size, 8)
    unbound = [place for place in words if library.get_qword_at_rva(place) and place not in listed]
    found.check(table.Size and not unbound, "the loader binds every import", f"{len(listed)} of {len(listed) + len(unbound)}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library", type=pathlib.Path)
    parser.add_argument("--release", action="store_true")
    parser.add_argument("--glibc")
    arguments = parser.parse_args()
    found, content = Found(), arguments.library.read_bytes()
    print(f"{arguments.library.name}: {len(content) / 1e6:.1f} MB")
    if content.startswith(b"\x7fELF"):
        elf(arguments.library, found, arguments.glibc)
    elif content.startswith(b"MZ"):
        pe(arguments.library, found)
    places = b"|".join(re.escape(place.encode()) for place in PLACES if len(place) > 1)
    paths = sorted(set(re.findall(rb"(?:" + places + rb")[/\\][\x20-\x7e]{3,}", content)))
    if arguments.release:
        found.check(not paths, "no path of the build machine", "; ".join(path.decode()[:120] for path in paths[:5]))
    else:
        print(f"       {len(paths)} paths of the build machine")
    print(f"\n{found.passed} passed, {found.failed} failed")
    sys.exit(found.failed > 0)


main()
