//! Saved states: bytes that were cut, changed, lengthened, or come from another model.

use super::mutate::{self, Random};
use super::run;
use tempfile::TempDir;
use wheelrail::fmi::instance::Instance;
use wheelrail::fmi::package::{self, PackedScene};
use wheelrail::fmi::version::Version;
use wheelrail::scene::load;

/// A scene unpacked as in an FMU.
pub struct Unpacked {
    pub folder: TempDir,
    pub packed: PackedScene,
}

pub fn unpack(scene: &str, changes: &[&str]) -> Unpacked {
    unpack_as(scene, changes, Version::Two)
}

pub fn unpack_as(scene: &str, changes: &[&str], version: Version) -> Unpacked {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let packed = package::pack_scene_as(&load::open(scene, &changes).unwrap(), version).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (path, content) in &packed.resources {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    Unpacked { folder, packed }
}

pub const MODELS: &[(&str, &[&str])] = &[
    ("suspended_wheelset", &[]),
    ("suspended_wheelset", &["contact.formulation=ACCF", "contact.on_lift=elastic"]),
    ("suspended_wheelset", &["contact.formulation=ECF-N"]),
    ("wheelset_s1002", &[]),
    ("wheelset_s1002", &["interface.outputs=[\"motion\", \"sliding_means\"]", "solver.integrator=generalised_alpha", "solver.step=0.001"]),
    ("wheelset_standstill", &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]),
    ("bogie", &["solver.integrator=real_time", "solver.step=0.001"]),
];

fn instance(unpacked: &Unpacked) -> Instance {
    Instance::new(unpacked.folder.path(), &unpacked.packed.description.guid).unwrap()
}

/// Magic, version, GUID and length, as `sim::serialized` has them.
const HEAD: usize = 8 + 4 + 38 + 8;
const SUM: usize = 4;

/// The checksum of what the bytes are now, as an attacker would write it.
fn sign(bytes: &mut [u8]) {
    if bytes.len() < HEAD + SUM {
        return;
    }
    let length = (bytes.len() - HEAD - SUM) as u64;
    bytes[HEAD - 8..HEAD].copy_from_slice(&length.to_le_bytes());
    let mut sum = crc32fast::Hasher::new();
    sum.update(&bytes[..HEAD]);
    sum.update(&bytes[HEAD + SUM..]);
    bytes[HEAD..HEAD + SUM].copy_from_slice(&sum.finalize().to_le_bytes());
}

#[test]
fn prop_any_saved_state_is_refused_or_the_one_it_was() {
    let unpacked: Vec<Unpacked> = MODELS.iter().map(|(scene, changes)| unpack(scene, changes)).collect();
    // Before, during and after a run.
    let blobs: Vec<Vec<Vec<u8>>> = unpacked
        .iter()
        .map(|model| {
            let mut instance = instance(model);
            let mut blobs = vec![instance.serialize(&instance.save()).unwrap()];
            instance.setup_experiment(None, 0.0, None).unwrap();
            instance.enter_initialization().unwrap();
            instance.exit_initialization().unwrap();
            blobs.push(instance.serialize(&instance.save()).unwrap());
            for step in 0..3 {
                instance.do_step(0.01 * f64::from(step), 0.01).unwrap();
            }
            blobs.push(instance.serialize(&instance.save()).unwrap());
            blobs
        })
        .collect();
    let mut instances: Vec<Instance> = unpacked.iter().map(instance).collect();
    let mut counts = [0; 3];
    run::each("states", 300, |random: &mut Random, case| {
        let model = random.below(unpacked.len());
        let other = if random.once_in(4) { random.below(unpacked.len()) } else { model };
        let seed = random.of(&blobs[other]).clone();
        let mut bytes = seed.clone();
        for _ in 0..random.below(4) {
            mutate::bytes(random, &mut bytes);
        }
        let signed = random.once_in(2) && bytes != seed;
        if signed {
            sign(&mut bytes);
        }
        case.text = format!("model {model}, state of {other}, signed {signed}: {bytes:?}");
        run::now("states", &case.text);
        case.begin();
        let instance = &mut instances[model];
        // As bytes: memory that a forged state brought in may hold what equals nothing.
        let now = |instance: &Instance| instance.serialize(&instance.save()).unwrap();
        let before = now(instance);
        let Ok(saved) = instance.deserialize(&bytes) else {
            counts[0] += 1;
            assert!(now(instance) == before, "a refusal changes nothing");
            return;
        };
        assert!(
            signed
                || (bytes == seed && other == model)
                || unpacked[model].packed.description.guid == unpacked[other].packed.description.guid
        );
        if !signed {
            assert_eq!(instance.serialize(&saved).unwrap(), bytes, "read and written again");
        }
        if instance.restore(&saved).is_err() {
            counts[1] += 1;
            assert!(now(instance) == before || signed, "a refusal changes nothing");
            return;
        }
        counts[2] += 1;
        // Whatever a forged state holds: an answer or an error.
        let references: Vec<u32> = unpacked[model].packed.table.variables.iter().map(|v| v.reference).collect();
        let mut values = vec![0.0; 1];
        for reference in references {
            if instance.get_real(&[reference], &mut values).is_ok() {
                assert!(values[0].is_finite(), "{reference} is {}", values[0]);
            }
        }
        let time = instance.time();
        let _ = instance.do_step(time, 1e-4);
        case.within(20.0, "restoring and stepping");
    });
    println!("{counts:?} refused, not restored, restored");
}
