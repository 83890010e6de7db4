//! FMI 3.0's calls in any order with any arguments that a C compiler lets through, from within intermediate updates too.

use super::mutate::Random;
use super::run;
use super::states::{MODELS, Unpacked, unpack_as};
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};
use wheelrail::fmi::ffi::session::IntermediateUpdate;
use wheelrail::fmi::ffi::types::{Component, ComponentEnvironment, FmiString, FmuState, Status};
use wheelrail::fmi::ffi::v3::states::*;
use wheelrail::fmi::ffi::v3::values::*;
use wheelrail::fmi::ffi::v3::*;
use wheelrail::fmi::version::Version;

unsafe extern "C" fn listen(_: ComponentEnvironment, _: Status, category: FmiString, message: FmiString) {
    for text in [category, message] {
        assert!(text.is_null() || !unsafe { CStr::from_ptr(text) }.to_string_lossy().contains("internal error"), "a panic was caught");
    }
}

/// Who calls. The host's function in a step calls as another one, so that neither sees the other's data change.
struct Host<'a> {
    model: &'a Unpacked,
    random: Random,
    component: Component,
    states: Vec<FmuState>,
    time: f64,
    within: bool,
    log: String,
}

#[allow(clippy::too_many_arguments)] // the standard's signature
/// Calls back into the instance, as a host may and as it may not.
unsafe extern "C" fn update(
    environment: ComponentEnvironment,
    time: f64,
    _: bool,
    _: bool,
    _: bool,
    may_return: bool,
    wanted: *mut u8,
    at: *mut f64,
) {
    let host = unsafe { &mut *environment.cast::<Host>() };
    assert!(time.is_finite());
    let done = host.call();
    host.log.push_str(&format!("within at {time}: {done}\n"));
    if host.random.once_in(6) && (may_return || host.random.once_in(9)) {
        unsafe {
            *wanted = 1 + host.random.below(200) as u8;
            *at = if host.random.once_in(5) { f64::NAN } else { time + 1e-3 * (host.random.share() - 0.2) };
        }
    }
}

impl Host<'_> {
    fn variable(&mut self) -> (u32, f64) {
        let table = &self.model.packed.table;
        if self.random.once_in(12) {
            return (self.random.next() as u32, 1.0);
        }
        if !table.additions.arrays.is_empty() && self.random.once_in(6) {
            return (self.random.of(&table.additions.arrays).reference, 1.0);
        }
        let variable = self.random.of(&table.variables);
        (variable.reference, variable.start.unwrap_or(1.0))
    }

    fn call(&mut self) -> String {
        let c = if self.random.once_in(60) { null_mut() } else { self.component };
        let count = self.random.below(4);
        let (references, usual): (Vec<u32>, Vec<f64>) = (0..count).map(|_| self.variable()).unzip();
        let size: usize = references.iter().map(|reference| self.model.packed.table.size(*reference)).sum();
        let random = &mut self.random;
        let n = if random.once_in(10) { random.below(size + 3) } else { size };
        // Room for whatever is said to be there.
        let room = n.max(count) + 1;
        let vr = if random.once_in(30) { null() } else { references.as_ptr() };
        let given: Vec<f64> = (0..room).map(|i| usual.get(i).unwrap_or(&1.0) * random.share()).collect();
        let (mut reals, mut integers, mut truths) = (vec![f64::NAN; room], vec![0_i32; room], vec![3_u8; room]);
        let (mut strings, mut sizes, mut kinds): (Vec<FmiString>, Vec<usize>, Vec<u32>) =
            (vec![null(); room], vec![0; room], vec![0; room]);
        let orders: Vec<i32> = (0..room).map(|_| random.below(3) as i32).collect();
        let what = random.below(24);
        let status = unsafe {
            match what {
                0 => {
                    let (tolerance, end) = (random.share() * 1e-5, random.share());
                    fmi3EnterInitializationMode(c, random.below(2) as u8, tolerance, 0.0, random.below(2) as u8, end)
                }
                1 => fmi3ExitInitializationMode(c),
                2..=8 => self.step(c),
                9 | 10 => {
                    let status = fmi3GetFloat64(c, vr, count, reals.as_mut_ptr(), n);
                    if status == Status::Ok && count > 0 {
                        assert!(reals[..n].iter().all(|value| value.is_finite()), "{references:?} are {reals:?}");
                    }
                    status
                }
                11 | 12 => fmi3SetFloat64(c, vr, count, given.as_ptr(), n),
                13 => fmi3GetInt32(c, vr, count, integers.as_mut_ptr(), n),
                14 => fmi3GetBoolean(c, vr, count, truths.as_mut_ptr(), n),
                15 => fmi3SetBoolean(c, vr, count, truths.as_ptr(), n),
                16 => fmi3GetString(c, vr, count, strings.as_mut_ptr(), n),
                17 => fmi3GetOutputDerivatives(c, vr, count, orders.as_ptr(), reals.as_mut_ptr(), n),
                18 => self.state(c),
                19 => match random.below(6) {
                    0 => fmi3Terminate(c),
                    1 => fmi3Reset(c),
                    2 if self.within => {
                        fmi3FreeInstance(c);
                        Status::Ok
                    }
                    _ => fmi3SetDebugLogging(c, 1, 1, [c"logAll".as_ptr()].as_ptr()),
                },
                20 => fmi3EnterEventMode(c),
                21 => {
                    let mut flags = [7_u8; 5];
                    let [a, b, d, e, f] = &mut flags;
                    fmi3UpdateDiscreteStates(c, a, b, d, e, f, reals.as_mut_ptr())
                }
                22 => fmi3EnterStepMode(c),
                _ => {
                    let reference = references.first().copied().unwrap_or(0);
                    let mut found = 0;
                    let status = fmi3GetNumberOfVariableDependencies(c, reference, &mut found);
                    if status == Status::Ok {
                        sizes.resize(found, 0);
                        let mut others = sizes.clone();
                        kinds.resize(found, 0);
                        integers.resize(found, 0);
                        let (sizes, others) = (sizes.as_mut_ptr(), others.as_mut_ptr());
                        return format!(
                            "{:?}",
                            fmi3GetVariableDependencies(c, reference, sizes, kinds.as_mut_ptr(), others, integers.as_mut_ptr(), found)
                        );
                    }
                    status
                }
            }
        };
        format!("{what} {references:?} {n} {given:?}: {status:?}")
    }

    unsafe fn step(&mut self, c: Component) -> Status {
        let step = match self.random.below(8) {
            0 => 0.0,
            1 => f64::NAN,
            2 => 1e-12,
            _ => 5e-3 * self.random.share(),
        };
        let (mut flags, mut reached) = ([7_u8; 3], f64::NAN);
        let [event, terminate, early] = &mut flags;
        let status = unsafe { fmi3DoStep(c, self.time, step, 0, event, terminate, early, &mut reached) };
        if matches!(status, Status::Ok | Status::Warning) {
            assert!(reached.is_finite() && flags.iter().all(|flag| *flag < 2), "{flags:?} {reached}");
            self.time = reached;
        }
        status
    }

    fn state(&mut self, c: Component) -> Status {
        let known = self.states.last().copied().unwrap_or(null_mut());
        unsafe {
            match self.random.below(4) {
                0 => {
                    let mut state = null_mut();
                    let status = fmi3GetFMUState(c, &mut state);
                    if status == Status::Ok {
                        self.states.push(state);
                    }
                    status
                }
                1 => fmi3SetFMUState(c, known),
                2 => {
                    let mut size = 0;
                    let status = fmi3SerializedFMUStateSize(c, known, &mut size);
                    if status == Status::Ok {
                        let mut bytes = vec![0; size];
                        assert_eq!(fmi3SerializeFMUState(c, known, bytes.as_mut_ptr(), size), Status::Ok);
                        let mut state = null_mut();
                        assert_eq!(fmi3DeserializeFMUState(c, bytes.as_ptr(), size, &mut state), Status::Ok);
                        self.states.push(state);
                    }
                    status
                }
                _ => {
                    let mut state = self.states.pop().unwrap_or(null_mut());
                    let status = fmi3FreeFMUState(c, &mut state);
                    if !state.is_null() {
                        self.states.push(state);
                    }
                    status
                }
            }
        }
    }
}

#[test]
fn fmu_calls_of_three_in_any_order_never_panic_and_never_answer_what_is_no_number() {
    let models: Vec<Unpacked> = MODELS.iter().map(|(scene, changes)| unpack_as(scene, changes, Version::Three)).collect();
    run::each("calls3", 60, |random: &mut Random, case| {
        let model: &Unpacked = random.of(&models);
        let packed = &model.packed;
        let token = CString::new(packed.description.guid.clone()).unwrap();
        let folder = CString::new(model.folder.path().to_str().unwrap()).unwrap();
        let open: Vec<u32> = packed.table.outputs.iter().map(|output| output.reference).chain([1001]).collect();
        let (events, early, updates) = (random.below(2) as u8, random.below(2) as u8, random.once_in(2));
        let mut host = |within| Host {
            model,
            random: Random::new(random.next()),
            component: null_mut(),
            states: Vec::new(),
            time: 0.0,
            within,
            log: String::new(),
        };
        let (mut host, mut guest) = (host(false), Box::new(host(true)));
        case.begin();
        let own: ComponentEnvironment = (&raw mut *guest).cast();
        let (name, n) = (c"one".as_ptr(), open.len());
        let (token, folder) = (token.as_ptr(), folder.as_ptr());
        let update: Option<IntermediateUpdate> = if updates { Some(update) } else { None };
        let component =
            unsafe { fmi3InstantiateCoSimulation(name, token, folder, 0, 1, events, early, open.as_ptr(), n, own, Some(listen), update) };
        assert!(!component.is_null());
        host.component = component;
        unsafe { (*own.cast::<Host>()).component = component };
        if host.random.once_in(2) {
            unsafe {
                fmi3EnterInitializationMode(component, 0, 0.0, 0.0, 0, 0.0);
                fmi3ExitInitializationMode(component);
            }
        }
        for _ in 0..40 {
            let done = host.call();
            host.log.push_str(&done);
            host.log.push('\n');
            let within = unsafe { &(*own.cast::<Host>()).log };
            case.text = format!("{}\n{}{within}", model.packed.scene.name, host.log);
            run::now("calls3", &case.text);
        }
        unsafe {
            let guests = std::mem::take(&mut (*own.cast::<Host>()).states);
            for mut state in std::mem::take(&mut host.states).into_iter().chain(guests) {
                fmi3FreeFMUState(component, &mut state);
            }
            fmi3FreeInstance(component);
        }
        case.within(60.0, "40 calls");
    });
}
