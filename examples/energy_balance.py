#!/usr/bin/env python3
"""Energy balance of an electric train over 10 km: what the motors bring in, and where it goes.

    pip install fmpy
    python examples/energy_balance.py -o energy_balance.svg

Three coaches (examples/electric_train.toml) start from rest, run at 100 km/h through a curve of 1000 m and up 30 m, and brake to rest with discs. A driver written here sets motor and brake
torques. Every number is an output of the FMU's group `energy`: integrals that the integrator carries along without giving them a part in its error control, so that
asking for them does not change the run.

Compared with formulas: the books must close (1e-3 of what the motors brought in), weight's energy is m g h, and the resistance's heat is the integral of Davis' formula over the way driven.

Left out: everything electrical before the rotor (an efficiency of 0.9 is assumed for one line of the table), losses of gears, hotel power, regeneration.
"""

from partner import HERE, Fmu, Instance, Report, arguments, draw

EFFICIENCY = 0.9
TRACTION, BRAKING = 1200.0, 0.8  # N m of each motor, m/s2
GAIN = 600.0  # N m per m/s
RADIUS, GRAVITY = 0.46, 9.81  # m, m/s2
COACH = 32000.0 + 2 * 2615.0 + 4 * 1813.0  # kg
DAVIS = (600.0, 10.0, 2.0)  # N, N s/m, kg/m of each coach
CLIMB = [(2000.0, 0.0), (2100.0, 0.5), (5000.0, 29.5), (5100.0, 30.0)]  # m along the track, m of height
LEAD = "coach[1].truck[1].wheelset[1]"


def height(distance):
    if distance <= CLIMB[0][0]:
        return 0.0
    for (a, low), (b, high) in zip(CLIMB, CLIMB[1:]):
        if distance < b:
            share = (distance - a) / (b - a)
            # The grade itself is a ramp in the first and last part.
            return low + (high - low) * (share if b == 5000.0 else share**2 if low == 0.0 else 2.0 * share - share**2)
    return CLIMB[-1][1]


class Books:
    """Sums of outputs by account, J."""

    def __init__(self, vehicle):
        self.vehicle, names = vehicle, vehicle.fmu.names
        motors = lambda end: [name for name in names(end) if ".motor" in name]
        heat = lambda word: [name for name in names(".heat") if f".{word}" in name]
        self.accounts = {
            "motors": motors(".work"), "drives": motors(".heat"), "brakes": heat("brake"), "resistance": heat("resistance"),
            "creep": names(".frictionHeat"), "suspensions": ["energy.suspensionHeat"], "contact": ["energy.contactWork"],
            "kinetic": ["energy.kinetic"], "weight": ["energy.height"], "elements": ["energy.elements"],
        }
        self.begin = {name: 0.0 for name in self.accounts}
        self.begin = self.read()

    def read(self):
        """Since the start."""
        return {name: sum(self.vehicle.get(outputs)) - self.begin[name] for name, outputs in self.accounts.items()}


def left_over(books):
    stored = books["kinetic"] + books["weight"] + books["elements"]
    heat = sum(books[name] for name in ("drives", "brakes", "resistance", "creep", "suspensions"))
    return books["motors"] - heat + books["contact"] - stored


def travel(fmu, way, top, step):
    """Rows of time, distance, speed and books until the train stands."""
    rows = []
    with Instance(fmu) as train:
        books = Books(train)
        motors, brakes = fmu.names(".torque", "input"), fmu.names(".largestTorque", "input")
        mass = COACH * len(fmu.names("resistance.force"))
        begin, standing = train.get([f"{LEAD}.distance"])[0], 0.0
        while standing < 3.0:
            distance, speed = train.get([f"{LEAD}.distance", f"{LEAD}.vx"])
            rows.append((train.time, distance, speed, books.read()))
            slows = way - (distance - begin) <= speed**2 / (2.0 * BRAKING)
            torque = 0.0 if slows else min(max(GAIN * (top - speed), 0.0), TRACTION)
            train.set({name: torque for name in motors})
            train.set({name: BRAKING * mass * RADIUS / len(brakes) if slows else 0.0 for name in brakes})
            train.step(step)
            standing += step if slows and abs(speed) < 1e-3 else 0.0
        rows.append((train.time, *train.get([f"{LEAD}.distance", f"{LEAD}.vx"]), books.read()))
    return rows, mass


def main():
    asked = arguments(__doc__, step=1.0, seed="not used")
    way, top = (250.0, 10.0) if asked.short else (10000.0, 100.0 / 3.6)
    report = Report()
    with Fmu.of_scene(HERE / "electric_train.toml") as fmu:
        rows, mass = travel(fmu, way, top, asked.step)
    time, distance, _, books = rows[-1]
    given = books["motors"]
    print(f"{distance - rows[0][1]:.1f} m in {time:.1f} s, {mass / 1e3:.2f} t, communication step {asked.step:g} s\n")
    lines = [("electrical input (efficiency 0.9 assumed)", given / EFFICIENCY), ("mechanical input of the motors", given)]
    lines += [(text, books[name]) for text, name in [
        ("kinetic energy", "kinetic"), ("energy of weight", "weight"), ("springs and rotors", "elements"), ("heat of brakes", "brakes"),
        ("heat of running resistance", "resistance"), ("heat and wear of creepage", "creep"), ("heat of suspensions", "suspensions"), ("heat of drives", "drives")]]
    lines += [("contact beside friction", -books["contact"]), ("left over", left_over(books))]
    for text, value in lines:
        print(f"  {text:44}{value / 1e6:12.4f} MJ {value / 3.6e6:10.4f} kWh {100.0 * value / given:10.4f} %")
    print()
    report.below("left over at any time, of the input", max(abs(left_over(row[3])) for row in rows) / given, 1e-3)
    steps = list(zip(rows, rows[1:]))
    davis = sum(0.5 * (b[1] - a[1]) * sum(c * (a[2] ** n + b[2] ** n) for n, c in enumerate(DAVIS)) for a, b in steps) * mass / COACH
    report.near("heat of running resistance", books["resistance"] / 1e6, davis / 1e6, 5e-3, "MJ")
    if not asked.short:
        report.near("energy of weight", books["weight"] / 1e6, mass * GRAVITY * (height(distance) - height(rows[0][1])) / 1e6, 2e-3, "MJ")
    # All kinetic energy of bodies: rolling wheelsets (112 kg m2 each) and the rest; the train is at its fastest then.
    fastest = max(rows, key=lambda row: row[2])
    rolling = 0.5 * fastest[2] ** 2 * mass * (1.0 + 4 * 112.0 / RADIUS**2 / COACH)
    report.near("kinetic energy at the greatest speed", fastest[3]["kinetic"] / 1e6, rolling / 1e6, 2e-3, "MJ")
    if asked.picture:
        x = [(row[1] - rows[0][1]) / 1e3 for row in rows]
        account = lambda name: (name, x, [row[3][name] / 1e6 for row in rows])
        draw(asked.picture, "Energy of an electric train of 133 t", "distance, km", [
            ("speed, km/h", [("train", x, [3.6 * row[2] for row in rows])], []),
            ("in and stored, MJ", [account("motors"), account("kinetic"), account("weight")], []),
            ("turned into heat, MJ", [account("resistance"), account("brakes")], []),
            ("turned into heat, MJ", [account("creep"), account("suspensions"), account("drives")], []),
            ("left over, kJ", [("balance", x, [left_over(row[3]) / 1e3 for row in rows])], []),
        ])
    report.finish()


if __name__ == "__main__":
    main()
