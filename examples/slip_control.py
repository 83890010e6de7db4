"""Anti-slip control of one axle as an FMU of its own, by pythonfmu: `pythonfmu build -f slip_control.py`.

A PI controller on the slip speed cuts the torque that the driver asks for. `target` is the slip speed at the adhesion's maximum. Beyond it adhesion falls with slip (f' < 0) and the
axle of the reduced mass m = J / r^2 runs away with -f' / m; a cut of `gain` per m/s holds it where gain x ratio / r > -f'. The cut neither grows beyond the torque asked for nor below
zero, so that nothing winds up.
"""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class SlipControl(Fmi2Slave):
    description = "anti-slip control of one driven axle"

    def __init__(self, **options):
        super().__init__(**options)
        self.demand = self.slip = self.torque = self.integral = 0.0
        self.target, self.gain, self.time_constant, self.enabled = 0.75, 2000.0, 0.4, 1.0
        for name, text in [("demand", "torque asked for, N m"), ("slip", "slip speed, m/s, positive when driving")]:
            self.register_variable(Real(name, causality=Fmi2Causality.input, description=text))
        self.register_variable(Real("torque", causality=Fmi2Causality.output, description="torque of the motor, N m"))
        for name, text in [("target", "slip speed, m/s"), ("gain", "cut per slip speed, N m s/m"), ("time_constant", "of the integral part, s"),
                           ("enabled", "0: the torque asked for goes to the motor")]:
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, start=getattr(self, name), description=text))

    def do_step(self, current_time, step_size):
        if self.enabled == 0.0:
            self.torque = self.demand
            return True
        beyond = self.slip - self.target
        most = max(0.0, self.demand)
        grown = self.integral + self.gain * beyond * step_size / self.time_constant
        self.integral = min(max(grown, 0.0), most)
        cut = min(max(self.integral + self.gain * beyond, 0.0), most)
        self.torque = self.demand - cut
        return True
