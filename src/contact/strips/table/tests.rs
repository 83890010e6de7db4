use super::super::{Part, Parts, RailStrips, Scratch, Section, press_anywhere};
use super::*;
use crate::contact::search::algebraic::Pair;
use crate::geometry::Side;
use crate::geometry::profile::test_profiles::built_in;
use crate::geometry::profile::{Part as Of, Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::waves::Stretch;
use crate::geometry::track::{Deviation, Direction, Rail};
use crate::math::rotation::AxleFrame;
use nalgebra::{Matrix3, Vector3};
use std::sync::{Arc, LazyLock};

/// A pair of profiles and its table.
struct Tabled {
    wheel: Arc<dyn Profile>,
    rail: Arc<dyn Profile>,
    strips: RailStrips,
    table: PatchTable,
}

/// Of the wheel's tread circle and the rail's origin from the middle of the track, m.
const HALF: (f64, f64) = (0.75, 0.753);

impl Tabled {
    fn new(wheel: &str, rail: &str) -> Tabled {
        Tabled::of(built_in(wheel, Of::Wheel), built_in(rail, Of::Rail))
    }

    fn of(wheel: Arc<dyn Profile>, rail: Arc<dyn Profile>) -> Tabled {
        let straight = Rail::new(Side::Left, rail.clone(), HALF.1, 1.0 / 40.0, &[]);
        let own = Wheel { side: Side::Left, profile: wheel.clone(), half_spacing: HALF.0 };
        let strips = RailStrips::new(&straight, std::iter::once(&own));
        let (centre, axes) = (Vector3::z() * 0.46, Matrix3::identity());
        let pair = Pair { wheel: &own, rail: &straight, centre: &centre, axes: &axes, distance: 0.0 };
        let middle = Standing::new(&pair, &Section::new(&pair));
        let table = PatchTable::make(&ToTabulate {
            strips: strips.clone(),
            rail: rail.clone(),
            wheel: wheel.clone(),
            middle: (middle.across, middle.lean),
        });
        Tabled { wheel, rail, strips, table }
    }

    fn wheel(&self, side: Side) -> Wheel {
        Wheel { side, profile: self.wheel.clone(), half_spacing: HALF.0 }
    }

    fn rail(&self, side: Side, deviations: &[Deviation]) -> Rail {
        Rail::new(side, self.rail.clone(), HALF.1, 1.0 / 40.0, deviations)
    }

    fn looked(&self, pair: &Pair, material: Material) -> Option<Looked> {
        self.table.look(pair, &Section::new(pair), material)
    }

    /// What the strips make of it as one.
    fn pressed(&self, pair: &Pair, scratch: &mut Scratch) -> Option<Part> {
        let pressed = press_anywhere(pair, &self.strips, STEEL, scratch);
        let parts = Parts::new(pressed, &self.strips, 1);
        (!parts.is_empty()).then(|| Part::new(parts.share(pressed, 0, 0), &self.strips, self.wheel.as_ref(), STEEL))
    }

    /// Height of the wheelset's centre at which the left or right wheel carries about a load, N, and the pose.
    fn under(
        &self,
        (wheel, rail): (&Wheel, &Rail),
        (y, roll, yaw): (f64, f64, f64),
        load: f64,
        scratch: &mut Scratch,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        let axes = AxleFrame::new(yaw, roll).axes;
        let (mut low, mut high) = (0.44, 0.48);
        // To 1e-12 m: the weight goes with the height too.
        for _ in 0..36 {
            let middle = 0.5 * (low + high);
            let centre = Vector3::new(0.0, y, middle);
            let pair = Pair { wheel, rail, centre: &centre, axes: &axes, distance: 0.0 };
            // Deeper than strips look nothing is found: too deep.
            let deep = middle < 0.455;
            let carries = self.pressed(&pair, scratch).map_or(if deep { f64::INFINITY } else { 0.0 }, |part| part.load);
            if carries > load { low = middle } else { high = middle }
        }
        (Vector3::new(0.0, y, low), axes)
    }
}

static S1002: LazyLock<Tabled> = LazyLock::new(|| Tabled::new("kind = \"s1002\"\nradius = 0.46\n", "kind = \"60e1\"\n"));

/// Numbers from -1 to 1.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 99u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    }
}

/// Over nanometres all of a patch is a line: sums in single precision scattered by 1e-7, and creep forces with them.
#[test]
fn prop_what_a_table_says_does_not_scatter() {
    let (own, mut scratch) = (&*S1002, Scratch::new(S1002.strips.len()));
    let (wheel, rail) = (own.wheel(Side::Left), own.rail(Side::Left, &[]));
    let (centre, axes) = own.under((&wheel, &rail), (7e-4, 1e-4, 2e-3), 55e3, &mut scratch);
    let said: Vec<[f64; 5]> = (0..20)
        .map(|k| {
            let centre = centre + Vector3::y() * (1e-9 * f64::from(k));
            let looked = own.looked(&Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 }, STEEL).unwrap();
            let (part, outermost) = (looked.part, looked.fifths.each[4]);
            [part.force, part.patch.a, part.patch.b, outermost.across, outermost.size]
        })
        .collect();
    for k in 0..5 {
        let bends = said.windows(3).map(|three| (three[0][k] - 2.0 * three[1][k] + three[2][k]).abs() / three[1][k].abs());
        let worst = bends.fold(0.0, f64::max);
        println!("number {k} scatters by {worst:.1e}");
        assert!(worst < 2e-10 && said[0][k] != said[19][k], "{k}: {worst:e}");
    }
}

#[test]
fn prop_between_its_nodes_a_table_says_what_strips_do() {
    let apta = Tabled::new("kind = \"apta\"\ndesign = \"APTA140\"\nradius = 0.46\n", "kind = \"uic60\"\n");
    for (name, own) in [("S1002 on 60E1", &*S1002), ("APTA140 on UIC60", &apta)] {
        let (mut random, mut scratch) = (random(), Scratch::new(own.strips.len()));
        let (mut sums, mut worst, mut count, mut all) = ([0.0f64; 6], [0.0f64; 6], 0, 0);
        for k in 0..600 {
            let side = Side::BOTH[k % 2];
            let (wheel, rail) = (own.wheel(side), own.rail(side, &[]));
            let pose = (6e-3 * random(), 3e-3 * random(), if k % 3 == 0 { 0.0 } else { 1e-2 * random() });
            let load = 1e4 * 10f64.powf(0.5 + 0.5 * random());
            let (centre, axes) = own.under((&wheel, &rail), pose, load, &mut scratch);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 };
            let pressed = press_anywhere(&pair, &own.strips, STEEL, &mut scratch);
            let flank = own.strips.carries_beyond(FLANK, pressed);
            all += 1;
            let Some(looked) = own.looked(&pair, STEEL).filter(|looked| looked.weight == 1.0 && !flank) else { continue };
            let (said, part) = (looked.part, own.pressed(&pair, &mut scratch).unwrap());
            let off = [
                said.force / part.force - 1.0,
                (said.arm - part.arm).norm(),
                (said.normal - part.normal).norm(),
                said.patch.a / part.patch.a - 1.0,
                said.patch.b / part.patch.b - 1.0,
                said.lead - part.lead,
            ];
            count += 1;
            for (k, off) in off.into_iter().enumerate() {
                sums[k] += off.abs();
                worst[k] = worst[k].max(off.abs());
            }
        }
        let mean = sums.map(|sum| sum / f64::from(count));
        println!("{name}, {count} of {all} poses inside: N, centre [m], normal, a, b, lead [m]: {mean:.6?}, at worst {worst:.5?}");
        assert!(count > 200);
        assert!(mean[0] < 1e-3 && worst[0] < 0.025, "N");
        assert!(mean[1] < 1e-5 && worst[1] < 2.5e-4 && worst[5] < 1e-5, "centre");
        assert!(mean[2] < 4e-5 && worst[2] < 1e-3, "normal");
        assert!(mean[3] < 2e-3 && mean[4] < 8e-3, "ellipse");
    }
}

#[test]
fn prop_sides_mirror_each_other_and_loads_go_with_the_modulus() {
    let own = &*S1002;
    let mut scratch = Scratch::new(own.strips.len());
    let (left, right) = ((own.wheel(Side::Left), own.rail(Side::Left, &[])), (own.wheel(Side::Right), own.rail(Side::Right, &[])));
    let (centre, axes) = own.under((&left.0, &left.1), (1.3e-3, 4e-4, 6e-3), 5e4, &mut scratch);
    let mirrored = (Vector3::new(0.0, -centre.y, centre.z), AxleFrame::new(-6e-3, -4e-4).axes);
    let look = |(wheel, rail): &(Wheel, Rail), centre: &Vector3<f64>, axes: &Matrix3<f64>, material: Material| {
        own.looked(&Pair { wheel, rail, centre, axes, distance: 0.0 }, material).unwrap()
    };
    let (a, b) = (look(&left, &centre, &axes, STEEL), look(&right, &mirrored.0, &mirrored.1, STEEL));
    let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
    assert!((a.part.load / b.part.load - 1.0).abs() < 1e-9);
    assert!((a.part.arm - mirror(b.part.arm)).norm() < 1e-12 && (a.part.normal - mirror(b.part.normal)).norm() < 1e-12);
    assert!((a.part.lead - b.part.lead).abs() < 1e-12 && a.part.lead.abs() > 1e-5);
    let soft = look(&left, &centre, &axes, Material { youngs_modulus: 1.05e11, ..STEEL });
    assert!((2.0 * soft.part.load / a.part.load - 1.0).abs() < 1e-12 && soft.part.patch == a.part.patch);
}

/// A rail that bends upwards and to the side, and climbs.
#[test]
fn prop_a_rail_that_bends_along_the_track_is_in_it() {
    #[derive(Debug)]
    struct Bent {
        slope: f64,
        bend: f64,
    }
    impl crate::geometry::track::DeviationShape for Bent {
        fn at(&self, s: f64) -> [f64; 4] {
            [self.slope * s + 0.5 * self.bend * s * s, self.slope + self.bend * s, self.bend, 0.0]
        }
        fn breaks(&self) -> Vec<f64> {
            Vec::new()
        }
        fn waves(&self) -> Vec<Stretch> {
            vec![Stretch { from: -10.0, to: 10.0, wave: 20.0 }]
        }
        fn describe(&self) -> String {
            "bent".into()
        }
    }
    let own = &*S1002;
    let mut scratch = Scratch::new(own.strips.len());
    let bent = |direction, slope, bend| Deviation { side: Side::Left, direction, shape: Arc::new(Bent { slope, bend }) };
    for (up, out) in [((0.0, 0.02), (0.0, 0.0)), ((4e-3, -0.02), (3e-3, 2e-3)), ((-6e-3, 0.0), (-5e-3, 0.0))] {
        let rail = own.rail(Side::Left, &[bent(Direction::Vertical, up.0, up.1), bent(Direction::Lateral, out.0, out.1)]);
        let wheel = own.wheel(Side::Left);
        let (centre, axes) = own.under((&wheel, &rail), (2.1e-3, 2e-4, 2e-3), 5e4, &mut scratch);
        let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 };
        let (said, part) = (own.looked(&pair, STEEL).unwrap().part, own.pressed(&pair, &mut scratch).unwrap());
        let off = (said.force / part.force - 1.0, (said.arm - part.arm).norm(), said.lead - part.lead, (said.normal - part.normal).norm());
        println!("up {up:?}, out {out:?}: N, centre, lead, normal off by {off:.6?}");
        assert!(off.0.abs() < 4e-3 && off.1 < 3e-5 && off.2.abs() < 1e-5 && off.3 < 1.5e-4, "{off:?}");
    }
}

/// A rail that is worn hollow.
#[derive(Debug)]
struct Hollow {
    whole: Arc<dyn Profile>,
    middle: f64,
}

impl Profile for Hollow {
    fn at(&self, x: f64) -> ProfilePoint {
        let (depth, width) = (1.5e-4, 4e-3);
        let (at, t) = (self.whole.at(x), (x - self.middle) / width);
        let value = depth * (-t * t).exp();
        let d1 = -2.0 * t / width * value;
        let d2 = (4.0 * t * t - 2.0) / (width * width) * value;
        ProfilePoint { value: at.value - value, d1: at.d1 - d1, d2: at.d2 - d2, d3: at.d3 }
    }
    fn range(&self) -> (f64, f64) {
        self.whole.range()
    }
    fn describe(&self) -> String {
        format!("{} hollow at {}", self.whole.describe(), self.middle)
    }
}

/// One ellipse over two lobes is no patch: strips are asked there, and where the lobes have become one the table says it.
#[test]
fn prop_where_a_patch_has_two_lobes_strips_are_asked() {
    let mut scratch = Scratch::new(S1002.strips.len());
    let (wheel, rail) = (S1002.wheel(Side::Left), S1002.rail(Side::Left, &[]));
    let (centre, axes) = S1002.under((&wheel, &rail), (2e-3, 0.0, 0.0), 5e4, &mut scratch);
    let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 };
    let middle = S1002.pressed(&pair, &mut scratch).unwrap().coordinates[1];
    let own = Tabled::of(S1002.wheel.clone(), Arc::new(Hollow { whole: S1002.rail.clone(), middle }));
    let (mut scratch, rail) = (Scratch::new(own.strips.len()), own.rail(Side::Left, &[]));
    let (mut asked, mut said) = (0, 0);
    for y in [0.0, 1e-3, 2e-3, 3e-3] {
        for load in [2e3, 5e3, 1e4, 3e4, 6e4, 1e5, 1.4e5] {
            let (centre, axes) = own.under((&wheel, &rail), (y, 0.0, 0.0), load, &mut scratch);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 };
            let part = own.pressed(&pair, &mut scratch).unwrap();
            // The area that presses: half lengths as wide as the ellipse's.
            let sum: f64 = scratch.pressed().iter().filter(|own| own.load > 0.0).map(|own| 2.0 * own.half_length * own.width).sum();
            let presses = sum * (0.8f64 * part.patch.a * part.patch.a / part.mean_square).sqrt();
            let (larger, weight) =
                (std::f64::consts::PI * part.patch.a * part.patch.b / presses, own.looked(&pair, STEEL).map_or(0.0, |found| found.weight));
            println!("y {y}, {load} N: {larger:.2} of what presses, weight {weight:.2}");
            assert!(larger < 1.7 || weight == 0.0, "y {y}, {load} N");
            asked += i32::from(larger > 1.7);
            said += i32::from(weight == 1.0);
        }
    }
    assert!(asked > 3 && said > 3, "{asked} {said}");
}

/// A profile less what is worn off it, m, with two derivatives.
#[derive(Debug)]
struct Worn {
    whole: Arc<dyn Profile>,
    off: fn(f64) -> [f64; 3],
}

impl Profile for Worn {
    fn at(&self, x: f64) -> ProfilePoint {
        let (at, off) = (self.whole.at(x), (self.off)(x));
        ProfilePoint { value: at.value - off[0], d1: at.d1 - off[1], d2: at.d2 - off[2], d3: at.d3 }
    }
    fn range(&self) -> (f64, f64) {
        self.whole.range()
    }
    fn describe(&self) -> String {
        format!("{} worn", self.whole.describe())
    }
}

/// 1.5 mm from the tread.
fn hollow(u: f64) -> [f64; 3] {
    const WIDTH: f64 = 18e-3;
    let (t, value) = (u / WIDTH, 1.5e-3 * (-(u / WIDTH).powi(4)).exp());
    let slope = 4.0 * t.powi(3) / WIDTH;
    [value, -slope * value, (slope * slope - 12.0 * t * t / (WIDTH * WIDTH)) * value]
}

/// 1.2 mm from the gauge side of a rail and 0.5 mm from its head.
fn planed(eta: f64) -> [f64; 3] {
    let s = 1.0 / (1.0 + ((eta + 22e-3) / 4e-3).exp());
    let (t, head) = (eta / 20e-3, 0.5e-3 * (-(eta / 20e-3).powi(2)).exp());
    let [side, by] = [1.2e-3, 4e-3];
    [
        side * s + head,
        -side * s * (1.0 - s) / by - 2.0 * t / 20e-3 * head,
        side * s * (1.0 - s) * (1.0 - 2.0 * s) / (by * by) + (4.0 * t * t - 2.0) / (20e-3 * 20e-3) * head,
    ]
}

/// Where a load passes from one hump to another within a node's distance the table says nothing that is far from strips (a half axis of -0.36 mm for 1.8, a creep force of nothing).
#[test]
fn prop_where_a_load_passes_from_hump_to_hump_strips_are_asked() {
    let worn = |whole: &Arc<dyn Profile>, off| -> Arc<dyn Profile> { Arc::new(Worn { whole: whole.clone(), off }) };
    let own = Tabled::of(worn(&S1002.wheel, hollow), worn(&S1002.rail, planed));
    let mut scratch = Scratch::new(own.strips.len());
    let (wheel, rail) = (own.wheel(Side::Left), own.rail(Side::Left, &[]));
    let (mut worst, mut said, mut asked) = ([0.0_f64; 2], 0, 0);
    for load in [1e4, 5e4, 1e5] {
        for k in 0..160 {
            let y = 0.8e-3 + 1.25e-5 * f64::from(k);
            let (centre, axes) = own.under((&wheel, &rail), (y, 0.0, 0.0), load, &mut scratch);
            let pair = Pair { wheel: &wheel, rail: &rail, centre: &centre, axes: &axes, distance: 0.0 };
            let strips = own.pressed(&pair, &mut scratch).unwrap();
            let Some(found) = own.looked(&pair, STEEL) else {
                asked += 1;
                continue;
            };
            said += i32::from(found.weight == 1.0);
            let [a, b] = [&found.part, &strips].map(|part| part.patch.a * part.patch.b);
            let off = [a / b - 1.0, (found.part.coordinates[1] - strips.coordinates[1]) / strips.patch.b];
            assert!(found.part.patch.b > 0.0, "y {y}, {load} N: {:?}", found.part.patch);
            for (worst, off) in worst.iter_mut().zip(off) {
                *worst = worst.max(found.weight * off.abs());
            }
        }
    }
    println!("area {:.3}, centre {:.3} of b; {said} said, {asked} asked", worst[0], worst[1]);
    assert!(worst[0] < 0.1 && worst[1] < 0.1 && said > 50 && asked > 50, "{worst:?} {said} {asked}");
}

#[test]
fn prop_saved_tables_are_the_same_and_damaged_ones_are_known() {
    let table = &S1002.table;
    let bytes = postcard::to_stdvec(table).unwrap();
    let read: PatchTable = postcard::from_bytes(&bytes).unwrap();
    assert!(read.is_whole() && read.tops == table.tops && read.fields == table.fields);
    let cut = PatchTable { tops: table.tops[1..].to_vec(), ..read };
    assert!(!cut.is_whole());
    println!("{:.1} MB", bytes.len() as f64 * 1e-6);
}

/// Along ways out of the table, across, in lean, in load and in yaw.
#[test]
fn prop_its_weight_falls_without_a_jump() {
    let own = &*S1002;
    let mut scratch = Scratch::new(own.strips.len());
    let (wheel, rail) = (own.wheel(Side::Left), own.rail(Side::Left, &[]));
    let weight = |y: f64, roll: f64, yaw: f64, depth: f64, centre: &Vector3<f64>| {
        let (place, axes) = (centre + Vector3::new(0.0, y, -depth), AxleFrame::new(yaw, roll).axes);
        let pair = Pair { wheel: &wheel, rail: &rail, centre: &place, axes: &axes, distance: 0.0 };
        own.looked(&pair, STEEL).map_or(0.0, |looked| looked.weight)
    };
    let (centre, _) = own.under((&wheel, &rail), (0.0, 0.0, 0.0), 5e4, &mut scratch);
    // Wheels that go aside or lean stand on other heights: on the touching ones, so that the load stays in the table.
    let on = |y: f64, roll: f64| own.under((&wheel, &rail), (y, roll, 0.0), 5e4, &mut Scratch::new(own.strips.len())).0 - Vector3::y() * y;
    let ways: [(&str, &dyn Fn(f64) -> f64); 5] = [
        ("outward", &|t| weight(9e-3 * t, 0.0, 0.0, 0.0, &on(9e-3 * t, 0.0))),
        ("lean", &|t| weight(0.0, 9e-3 * t, 0.0, 0.0, &on(0.0, 9e-3 * t))),
        ("lighter", &|t| weight(0.0, 0.0, 0.0, -9e-5 * t, &centre)),
        ("heavier", &|t| weight(0.0, 0.0, 0.0, 2e-4 * t, &centre)),
        ("yaw", &|t| weight(0.0, 0.0, 0.025 * t, 0.0, &centre)),
    ];
    for (name, at) in ways {
        let count = 200;
        let values: Vec<f64> = (0..=count).map(|k| at(f64::from(k) / f64::from(count))).collect();
        assert!(values[0] == 1.0 && values[count as usize] == 0.0, "{name}: {values:?}");
        let k =
            (0..count as usize).max_by(|a, b| (values[*a] - values[a + 1]).abs().total_cmp(&(values[*b] - values[b + 1]).abs())).unwrap();
        let (mut low, mut high) = (k as f64 / f64::from(count), (k + 1) as f64 / f64::from(count));
        let (mut below, mut above) = (values[k], values[k + 1]);
        while high - low > 1e-7 {
            let middle = 0.5 * (low + high);
            let value = at(middle);
            if (value - below).abs() > (above - value).abs() { (high, above) = (middle, value) } else { (low, below) = (middle, value) }
        }
        println!("{name}: largest change over 1e-7 of the way {:.1e}", (above - below).abs());
        assert!((above - below).abs() < 1e-4, "{name}: {below} {above}");
    }
}
