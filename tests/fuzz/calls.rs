//! FMI calls in any order with any arguments that a C compiler lets through.

use super::mutate::{NUMBERS, Random};
use super::run;
use super::states::{MODELS, Unpacked, unpack};
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};
use wheelrail::fmi::ffi::states::*;
use wheelrail::fmi::ffi::types::*;
use wheelrail::fmi::ffi::values::*;
use wheelrail::fmi::ffi::*;
use wheelrail::fmi::uri;
use wheelrail::fmi::variables::Kind;

/// Messages are read, as a host would; that is all.
unsafe extern "C" fn listen(_: ComponentEnvironment, name: FmiString, _: Status, category: FmiString, message: FmiString) {
    for text in [name, category, message] {
        assert!(text.is_null() || !unsafe { CStr::from_ptr(text) }.to_string_lossy().contains("internal error"), "a panic was caught");
    }
}

/// A number that a master may send: mostly near what the variable is.
fn value(random: &mut Random, usual: f64) -> f64 {
    match random.below(8) {
        0 => random.of(NUMBERS).parse().unwrap_or(f64::NAN),
        1 => 0.0,
        2 => -usual,
        _ => usual * (0.5 + random.share()),
    }
}

struct Host<'a> {
    model: &'a Unpacked,
    guid: CString,
    resources: CString,
    callbacks: CallbackFunctions,
    component: Component,
    states: Vec<FmuState>,
    time: f64,
    log: String,
}

impl Host<'_> {
    fn variable(&self, random: &mut Random) -> (u32, f64) {
        if random.once_in(12) {
            return (random.next() as u32, 1.0);
        }
        let variable = random.of(&self.model.packed.table.variables);
        (variable.reference, variable.start.unwrap_or(1.0))
    }

    fn instantiate(&mut self, random: &mut Random) {
        let wrong = random.once_in(10);
        let guid = if wrong && random.once_in(2) { c"{none}".as_ptr() } else { self.guid.as_ptr() };
        let kind = if wrong { random.below(4) as i32 } else { CO_SIMULATION };
        let name = if wrong && random.once_in(2) { null() } else { c"one".as_ptr() };
        let place = if wrong && random.once_in(2) { c"file:///nowhere%00".as_ptr() } else { self.resources.as_ptr() };
        let callbacks: *const CallbackFunctions = if wrong && random.once_in(3) { null() } else { &self.callbacks };
        self.component = unsafe { fmi2Instantiate(name, kind, guid, place, callbacks, FALSE, random.below(2) as i32) };
        assert!(wrong || !self.component.is_null());
    }

    /// One call; returns what it was.
    fn call(&mut self, random: &mut Random) -> String {
        let c = if random.once_in(60) { null_mut() } else { self.component };
        let count = random.below(4);
        let (references, usual): (Vec<u32>, Vec<f64>) = (0..count).map(|_| self.variable(random)).unzip();
        let vr = if random.once_in(30) { null() } else { references.as_ptr() };
        let mut reals = vec![f64::NAN; count];
        let mut integers = vec![0; count];
        let mut strings: Vec<FmiString> = vec![null(); count];
        let given: Vec<f64> = usual.iter().map(|usual| value(random, *usual)).collect();
        let orders: Vec<i32> = (0..count).map(|_| random.below(4) as i32 - 1 + i32::from(random.once_in(9)) * i32::MAX / 2).collect();
        let null_values = random.once_in(30);
        let what = random.below(26);
        let status = unsafe {
            match what {
                0 | 1 => fmi2SetupExperiment(
                    c,
                    random.below(2) as i32,
                    value(random, 1e-6),
                    value(random, 0.0),
                    random.below(2) as i32,
                    value(random, 1.0),
                ),
                2 | 3 => fmi2EnterInitializationMode(c),
                4 | 5 => fmi2ExitInitializationMode(c),
                6..=10 => {
                    let step = match random.below(8) {
                        0 => 0.0,
                        1 => -1e-3,
                        2 => f64::NAN,
                        3 => 1e-12,
                        _ => 5e-3 * random.share(),
                    };
                    let time = if random.once_in(8) { value(random, self.time) } else { self.time };
                    let status = fmi2DoStep(c, time, step, random.below(2) as i32);
                    let mut now = 0.0;
                    if fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &mut now) == Status::Ok {
                        assert!(now.is_finite());
                        self.time = now;
                    }
                    if status == Status::Ok && c == self.component {
                        self.check_outputs();
                    }
                    status
                }
                11 | 12 => {
                    let values = if null_values { null_mut() } else { reals.as_mut_ptr() };
                    let status = fmi2GetReal(c, vr, count, values);
                    if status == Status::Ok && count > 0 {
                        assert!(reals.iter().all(|value| value.is_finite()), "{references:?} are {reals:?}");
                    }
                    status
                }
                13 | 14 => fmi2SetReal(c, vr, count, if null_values { null() } else { given.as_ptr() }),
                15 => fmi2GetInteger(c, vr, count, if null_values { null_mut() } else { integers.as_mut_ptr() }),
                16 => fmi2GetBoolean(c, vr, count, if null_values { null_mut() } else { integers.as_mut_ptr() }),
                17 => fmi2SetBoolean(c, vr, count, if null_values { null() } else { orders.as_ptr() }),
                18 => fmi2GetString(c, vr, count, if null_values { null_mut() } else { strings.as_mut_ptr() }),
                19 => match random.below(3) {
                    0 => fmi2SetInteger(c, vr, count, orders.as_ptr()),
                    1 => fmi2SetString(c, vr, count, strings.as_ptr()),
                    _ => fmi2GetDirectionalDerivative(c, vr, count, vr, count, given.as_ptr(), reals.as_mut_ptr()),
                },
                20 => fmi2SetRealInputDerivatives(c, vr, count, orders.as_ptr(), if null_values { null() } else { given.as_ptr() }),
                21 => {
                    let status = fmi2GetRealOutputDerivatives(
                        c,
                        vr,
                        count,
                        orders.as_ptr(),
                        if null_values { null_mut() } else { reals.as_mut_ptr() },
                    );
                    if status == Status::Ok {
                        assert!(reals.iter().all(|value| value.is_finite()), "derivatives of {references:?} are {reals:?}");
                    }
                    status
                }
                22 => self.state(random, c),
                23 => match random.below(8) {
                    0 => fmi2Terminate(c),
                    1 => fmi2CancelStep(c),
                    _ => fmi2Reset(c),
                },
                24 => {
                    let categories = [c"logAll".as_ptr(), null()];
                    fmi2SetDebugLogging(
                        c,
                        random.below(2) as i32,
                        random.below(3),
                        if random.once_in(4) { null() } else { categories.as_ptr() },
                    )
                }
                _ => {
                    let mut status = Status::Ok;
                    let kind = random.below(5) as i32;
                    match random.below(4) {
                        0 => fmi2GetStatus(c, kind, &mut status),
                        1 => fmi2GetIntegerStatus(c, kind, integers.as_mut_ptr().or_null(count)),
                        2 => fmi2GetBooleanStatus(c, kind, integers.as_mut_ptr().or_null(count)),
                        _ => fmi2GetStringStatus(c, kind, strings.as_mut_ptr().or_null(count)),
                    }
                }
            }
        };
        format!("{what} {references:?} {given:?} {orders:?}: {status:?}")
    }

    /// After a step that ended well every output is a number.
    fn check_outputs(&self) {
        let reals = self.model.packed.table.variables.iter().filter(|v| v.kind == Kind::Real && v.causality == "output");
        let (references, names): (Vec<u32>, Vec<&str>) = reals.map(|v| (v.reference, v.name.as_str())).unzip();
        let mut values = vec![f64::NAN; references.len()];
        if unsafe { fmi2GetReal(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) } == Status::Ok {
            for (name, value) in names.iter().zip(&values) {
                assert!(value.is_finite(), "{name} is {value}");
            }
        }
    }

    fn state(&mut self, random: &mut Random, c: Component) -> Status {
        let known = self.states.last().copied().unwrap_or(null_mut());
        unsafe {
            match random.below(6) {
                0 | 1 => {
                    let mut state = null_mut();
                    let status = fmi2GetFMUstate(c, &mut state);
                    if status == Status::Ok {
                        self.states.push(state);
                    }
                    status
                }
                2 => fmi2SetFMUstate(c, known),
                3 => {
                    let mut size = 0;
                    let status = fmi2SerializedFMUstateSize(c, known, &mut size);
                    if status != Status::Ok {
                        return status;
                    }
                    let mut bytes = vec![0; size];
                    let short = if random.once_in(3) { random.below(size) } else { size };
                    let status = fmi2SerializeFMUstate(c, known, bytes.as_mut_ptr(), short);
                    let mut state = null_mut();
                    if fmi2DeSerializeFMUstate(c, bytes.as_ptr(), short, &mut state) == Status::Ok {
                        assert_eq!(short, size);
                        self.states.push(state);
                    }
                    status
                }
                4 => fmi2DeSerializeFMUstate(c, null(), 10, null_mut()),
                _ => {
                    let mut state = self.states.pop().unwrap_or(null_mut());
                    let status = fmi2FreeFMUstate(c, &mut state);
                    if !state.is_null() {
                        self.states.push(state);
                    }
                    status
                }
            }
        }
    }
}

/// Null where there is nothing to write to.
trait OrNull {
    fn or_null(self, count: usize) -> Self;
}
impl<T> OrNull for *mut T {
    fn or_null(self, count: usize) -> Self {
        if count == 0 { null_mut() } else { self }
    }
}

#[test]
fn fmu_calls_in_any_order_never_panic_and_never_answer_what_is_no_number() {
    let models: Vec<Unpacked> = MODELS.iter().map(|(scene, changes)| unpack(scene, changes)).collect();
    // A variadic function can't be written in stable Rust; one without the dots takes the same fixed arguments.
    let logger = unsafe {
        std::mem::transmute::<unsafe extern "C" fn(ComponentEnvironment, FmiString, Status, FmiString, FmiString), Logger>(listen)
    };
    run::each("calls", 60, |random: &mut Random, case| {
        let model = random.of(&models);
        let callbacks = CallbackFunctions {
            logger: (!random.once_in(5)).then_some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: null_mut(),
        };
        let mut host = Host {
            model,
            guid: CString::new(model.packed.description.guid.clone()).unwrap(),
            resources: CString::new(uri::from_path(model.folder.path())).unwrap(),
            callbacks,
            component: null_mut(),
            states: Vec::new(),
            time: 0.0,
            log: String::new(),
        };
        case.begin();
        host.instantiate(random);
        // Half of the cases begin as they should.
        if random.once_in(2) && !host.component.is_null() {
            unsafe {
                fmi2SetupExperiment(host.component, FALSE, 0.0, 0.0, FALSE, 0.0);
                fmi2EnterInitializationMode(host.component);
                fmi2ExitInitializationMode(host.component);
            }
        }
        for _ in 0..40 {
            let done = host.call(random);
            host.log.push_str(&done);
            host.log.push('\n');
            case.text = format!("{}\n{}", model.packed.scene.name, host.log);
            run::now("calls", &case.text);
        }
        unsafe {
            for mut state in std::mem::take(&mut host.states) {
                fmi2FreeFMUstate(host.component, &mut state);
            }
            fmi2FreeInstance(host.component);
        }
        case.within(60.0, "40 calls");
    });
}
