"""fmi3_loader.py FMU FOLDER

fmuloader as another master of FMI 3.0, with bindings of its own. FMU is the shipped scene for FMI 2.0; FOLDER holds for FMI 3.0 three.fmu (the same
scene) and dip.fmu (rigid contact, a dip in which a wheel lifts off and lands again).
"""

import os

import numpy as np
from fmuloader.fmi3 import Fmi3Slave

from common import TORQUE, grid, main
from common3 import Fmu3

STOP, STEP = 0.8, 0.01  # s


def settle(slave):
    while slave.update_discrete_states().discrete_states_need_update:
        pass
    slave.enter_step_mode()


def script(report, _two, folder):
    for name, events in (("three", False), ("dip", True)):
        report.section(f"{name}.fmu, {'with' if events else 'without'} events")
        with Fmu3(os.path.join(folder, f"{name}.fmu")) as fmu:
            references, torque = fmu.references(fmu.outputs), fmu.references([TORQUE])
            with fmu.instance(events=events, early=events) as other:
                other.set({TORQUE: 300.0})
                expected = other.run(grid(STOP, STEP))
            slave = Fmi3Slave(fmu.path, model_identifier=fmu.description.coSimulation.modelIdentifier)
            slave.instantiate_co_simulation("test", instantiation_token=fmu.description.guid, event_mode_used=events,
                                            early_return_allowed=events, log_message_callback=lambda *_: None)
            report.check(slave.get_version() == "3.0", "version")
            slave.enter_initialization_mode(start_time=0.0)
            slave.exit_initialization_mode()
            if events:
                settle(slave)
            slave.set_float64(torque, [300.0])
            time, rows, early = 0.0, [], 0
            for end in grid(STOP, STEP):
                while time < end:
                    result = slave.do_step(time, end - time)
                    time = result.last_successful_time
                    early += result.early_return
                    if result.event_handling_needed:
                        slave.enter_event_mode()
                        settle(slave)
                rows.append(slave.get_float64(references))
            report.same_bits(np.array(rows), expected, "results as with FMPy")
            report.check((early > 0) == events, "early returns", str(early))
            state = slave.get_fmu_state()
            data = slave.serialize_fmu_state(state)
            slave.free_fmu_state(state)
            state = slave.deserialize_fmu_state(data)
            slave.set_fmu_state(state)
            slave.free_fmu_state(state)
            report.same_bits(slave.get_float64(references), rows[-1], f"a state of {len(data)} bytes")
            slave.terminate()
            slave.free_instance()


if __name__ == "__main__":
    main(script, "FOLDER")
