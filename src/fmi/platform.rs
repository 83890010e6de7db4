//! Platforms: their names in FMI 2.0 and 3.0, and which one a shared library is made for, by its own header.

use super::version::Version;

/// A processor and a system, in FMI 3.0's words ("aarch64", "linux").
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Platform {
    architecture: &'static str,
    system: &'static str,
}

/// FMI 2.0's own names. For every other platform FMI 2.0.4 has those of FMI 3.0; "64" means x86 alone.
const OF_TWO: [(&str, &str, &str); 6] = [
    ("linux32", "x86", "linux"),
    ("linux64", "x86_64", "linux"),
    ("win32", "x86", "windows"),
    ("win64", "x86_64", "windows"),
    ("darwin32", "x86", "darwin"),
    ("darwin64", "x86_64", "darwin"),
];

const ARCHITECTURES: [&str; 5] = ["aarch32", "aarch64", "riscv64", "x86", "x86_64"];
const SYSTEMS: [&str; 3] = ["darwin", "linux", "windows"];

impl Platform {
    /// The one that this program runs on.
    pub fn host() -> Platform {
        let architecture = match std::env::consts::ARCH {
            "arm" => "aarch32",
            other => other,
        };
        let system = match std::env::consts::OS {
            "macos" => "darwin",
            other => other,
        };
        Platform { architecture, system }
    }

    /// By a name of either version.
    pub fn named(name: &str) -> Option<Platform> {
        if let Some((_, architecture, system)) = OF_TWO.into_iter().find(|row| row.0 == name) {
            return Some(Platform { architecture, system });
        }
        let (architecture, system) = name.split_once('-')?;
        let known = |list: &[&'static str], word: &str| list.iter().copied().find(|known| *known == word);
        Some(Platform { architecture: known(&ARCHITECTURES, architecture)?, system: known(&SYSTEMS, system)? })
    }

    /// All names that [`Platform::named`] knows, for messages.
    pub fn names() -> String {
        let two: Vec<&str> = OF_TWO.iter().map(|row| row.0).collect();
        format!("{} or ARCHITECTURE-SYSTEM with {} and {}", two.join(", "), ARCHITECTURES.join(", "), SYSTEMS.join(", "))
    }

    /// The folder below binaries/.
    pub fn folder(self, version: Version) -> String {
        let own = OF_TWO.into_iter().find(|row| version == Version::Two && (row.1, row.2) == (self.architecture, self.system));
        own.map_or_else(|| format!("{}-{}", self.architecture, self.system), |row| row.0.into())
    }

    /// What a shared library's file name ends with.
    pub fn suffix(self) -> &'static str {
        match self.system {
            "windows" => ".dll",
            "darwin" => ".dylib",
            _ => ".so",
        }
    }

    /// The platforms that a shared library is made for: one, or several of a universal one of macOS.
    ///
    /// # Errors
    /// A sentence, when the bytes are no shared library or one for a processor that is not known here.
    pub fn of_library(bytes: &[u8]) -> Result<Vec<Platform>, String> {
        let found = elf(bytes).or_else(|| portable_executable(bytes)).or_else(|| mach(bytes)).or_else(|| universal(bytes));
        found.unwrap_or_else(|| Err("this is not a shared library of Linux (ELF), Windows (PE) or macOS (Mach-O)".into()))
    }
}

type Found = Option<Result<Vec<Platform>, String>>;

fn two_bytes(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn four_bytes(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn one(architecture: Option<&'static str>, code: u32, system: &'static str, shared: bool) -> Result<Vec<Platform>, String> {
    if !shared {
        return Err(format!("this {system} file is no shared library"));
    }
    let architecture = architecture.ok_or_else(|| format!("this {system} library is made for a processor of unknown number {code:#x}"))?;
    Ok(vec![Platform { architecture, system }])
}

/// ELF, little-endian: type at byte 16 (3: shared object), machine at 18.
fn elf(bytes: &[u8]) -> Found {
    bytes.strip_prefix(b"\x7fELF")?;
    if bytes.get(5) != Some(&1) {
        return Some(Err("this linux library is made for a big-endian processor".into()));
    }
    let machine = two_bytes(bytes, 18)?;
    let architecture = match (machine, bytes[4]) {
        (3, 1) => Some("x86"),
        (62, 2) => Some("x86_64"),
        (40, 1) => Some("aarch32"),
        (183, 2) => Some("aarch64"),
        (243, 2) => Some("riscv64"),
        _ => None,
    };
    Some(one(architecture, machine.into(), "linux", two_bytes(bytes, 16)? == 3))
}

/// PE: where the header stands at byte 0x3c; the machine follows its signature, and characteristics (0x2000: DLL) 18 bytes later.
fn portable_executable(bytes: &[u8]) -> Found {
    bytes.strip_prefix(b"MZ")?;
    let header = usize::try_from(four_bytes(bytes, 0x3c)?).ok()?;
    bytes.get(header..)?.strip_prefix(b"PE\0\0")?;
    let machine = two_bytes(bytes, header + 4)?;
    let architecture = match machine {
        0x14c => Some("x86"),
        0x8664 => Some("x86_64"),
        0x1c4 => Some("aarch32"),
        0xaa64 => Some("aarch64"),
        _ => None,
    };
    Some(one(architecture, machine.into(), "windows", two_bytes(bytes, header + 22)? & 0x2000 != 0))
}

/// Processors of Mach-O.
fn mach_architecture(processor: u32) -> Option<&'static str> {
    match processor {
        7 => Some("x86"),
        0x0100_0007 => Some("x86_64"),
        0x0100_000c => Some("aarch64"),
        _ => None,
    }
}

/// Mach-O, little-endian: processor at byte 4, type at 12 (6: library, 8: bundle).
fn mach(bytes: &[u8]) -> Found {
    if !matches!(four_bytes(bytes, 0)?, 0xfeed_face | 0xfeed_facf) {
        return None;
    }
    let processor = four_bytes(bytes, 4)?;
    Some(one(mach_architecture(processor), processor, "darwin", matches!(four_bytes(bytes, 12)?, 6 | 8)))
}

/// A universal Mach-O, whose header is big-endian: number of parts at byte 4, then 20 bytes for each, its processor and its offset first and third.
fn universal(bytes: &[u8]) -> Found {
    if four_bytes(bytes, 0)?.swap_bytes() != 0xcafe_babe {
        return None;
    }
    let count = four_bytes(bytes, 4)?.swap_bytes();
    let mut platforms = Vec::new();
    // A class file of Java begins with the same bytes, and a large version in place of the number.
    for part in 0..usize::try_from(count).ok().filter(|count| (1..=8).contains(count))? {
        let offset = usize::try_from(four_bytes(bytes, 8 + 20 * part + 8)?.swap_bytes()).ok()?;
        match mach(bytes.get(offset..)?)? {
            Ok(found) => platforms.extend(found),
            Err(problem) => return Some(Err(problem)),
        }
    }
    Some(Ok(platforms))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The headers as their formats' specifications lay them out.
    fn header(length: usize, fields: &[(usize, &[u8])]) -> Vec<u8> {
        let mut bytes = vec![0; length];
        for (at, field) in fields {
            bytes[*at..*at + field.len()].copy_from_slice(field);
        }
        bytes
    }

    fn windows(machine: u16, characteristics: u16) -> Vec<u8> {
        let (machine, characteristics) = (machine.to_le_bytes(), characteristics.to_le_bytes());
        header(0x100, &[(0, b"MZ"), (0x3c, &[0x80]), (0x80, b"PE\0\0"), (0x84, &machine), (0x96, &characteristics)])
    }

    #[test]
    fn analytic_names_of_platforms_in_both_versions() {
        for (name, two, three, suffix) in [
            ("linux64", "linux64", "x86_64-linux", ".so"),
            ("x86_64-linux", "linux64", "x86_64-linux", ".so"),
            ("win64", "win64", "x86_64-windows", ".dll"),
            ("x86-windows", "win32", "x86-windows", ".dll"),
            ("darwin64", "darwin64", "x86_64-darwin", ".dylib"),
            ("aarch64-darwin", "aarch64-darwin", "aarch64-darwin", ".dylib"),
            ("aarch64-linux", "aarch64-linux", "aarch64-linux", ".so"),
        ] {
            let platform = Platform::named(name).unwrap();
            assert_eq!((platform.folder(Version::Two), platform.folder(Version::Three)), (two.into(), three.into()));
            assert_eq!(platform.suffix(), suffix);
            assert_eq!(Platform::named(two), Platform::named(three));
        }
        for unknown in ["", "linux", "arm64", "x86_64", "x86_64-", "-linux", "x86_64-linux-gnu", "Linux64"] {
            assert_eq!(Platform::named(unknown), None, "{unknown}");
        }
        let host = Platform::host();
        assert_eq!(Platform::named(&host.folder(Version::Three)), Some(host));
    }

    #[test]
    fn analytic_the_platform_of_a_library_stands_in_its_header() {
        let elf = |class: u8, machine: u16, kind: u8| {
            header(64, &[(0, b"\x7fELF"), (4, &[class, 1, 1]), (16, &[kind]), (18, &machine.to_le_bytes())])
        };
        let mach =
            |processor: u32, kind: u8| header(32, &[(0, &0xfeed_facf_u32.to_le_bytes()), (4, &processor.to_le_bytes()), (12, &[kind])]);
        let fat = {
            let part = |processor: u32, offset: u8| [&processor.to_be_bytes()[..], &[0; 4], &[0, 0, 0, offset], &[0; 8]].concat();
            let head = [&0xcafe_babe_u32.to_be_bytes()[..], &2_u32.to_be_bytes(), &part(0x0100_0007, 48), &part(0x0100_000c, 80)].concat();
            [head, mach(0x0100_0007, 6), mach(0x0100_000c, 6)].concat()
        };
        for (bytes, names) in [
            (elf(2, 62, 3), &["x86_64-linux"][..]),
            (elf(1, 3, 3), &["x86-linux"]),
            (elf(2, 183, 3), &["aarch64-linux"]),
            (windows(0x8664, 0x2022), &["x86_64-windows"]),
            (windows(0xaa64, 0x2022), &["aarch64-windows"]),
            (mach(0x0100_000c, 6), &["aarch64-darwin"]),
            (fat.clone(), &["x86_64-darwin", "aarch64-darwin"]),
        ] {
            let found: Vec<String> = Platform::of_library(&bytes).unwrap().iter().map(|platform| platform.folder(Version::Three)).collect();
            assert_eq!(found, names);
            // Cut off anywhere: no panic.
            for end in 0..bytes.len() {
                let _ = Platform::of_library(&bytes[..end]);
            }
        }
        for (bytes, problem) in [
            (b"text".to_vec(), "not a shared library"),
            (vec![], "not a shared library"),
            (elf(2, 62, 1), "no shared library"),
            (elf(2, 21, 3), "unknown number 0x15"),
            (windows(0x8664, 0x22), "no shared library"),
            (b"\xca\xfe\xba\xbe\0\0\0\x34 a class of Java".to_vec(), "not a shared library"),
        ] {
            let message = Platform::of_library(&bytes).unwrap_err();
            assert!(message.contains(problem), "{message}");
        }
        let own = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        if cfg!(target_os = "linux") {
            assert_eq!(
                Platform::of_library(&own),
                Ok(vec![Platform::host()]),
                "a position-independent program is an ELF shared object too"
            );
        }
    }
}
