//! The fast reference of `loop-fd` against the slow one, bit for bit; and whole meshes through both.

use crate::surface_meshes;

use crate::surface_meshes::{Random, assembled, shaken, zoo};
use subdiv_rtl::model::loop_fd::{Beat, LoopFd, direct};
use subdiv_rtl::model::render::render;
use subdiv_rtl::surface::packets::patches;
use subdiv_rtl::surface::table::Table;

/// Random control points of a patch of level `level` for the core, some of them extreme.
fn random_points(random: &mut Random, core: &LoopFd, level: u32) -> [[i128; 3]; 12] {
    let shift = 4 * (core.max_level() - level);
    let (low, high) = (-1i128 << (core.width() - 1), (1i128 << (core.width() - 1)) - 1);
    let kind = random.below(4);
    [0; 12].map(|_| {
        [0; 3].map(|_| {
            let x = i128::from(random.coordinate(core.width()));
            let fraction =
                i128::from(random.bits() & u64::MAX >> (64 - shift.max(1))) >> u32::from(shift == 0);
            match kind {
                0 => low << shift,
                1 => high << shift,
                2 => [low, high][random.below(2)] << shift,
                _ => ((x << shift) + fraction).min(high << shift),
            }
        })
    })
}

fn assert_same(core: &LoopFd, level: u32, points: &[[i128; 3]; 12]) {
    let expected = direct::beats(core, level, points);
    let beats = core.beats(level, points).unwrap();
    assert_eq!(beats.len(), expected.len());
    if let Some(at) = (0..beats.len()).find(|&b| beats[b] != expected[b]) {
        panic!("{core:?}, level {level}, beat {at}: {:?}, expected {:?}", beats[at], expected[at]);
    }
}

#[test]
fn fast_and_slow_agree_at_low_levels_on_many_patches() {
    let mut random = Random(1);
    for (width, max_level) in
        [(24, 6), (2, 0), (8, 2), (16, 8), (20, 10), (24, 9), (32, 6), (32, 10), (31, 7)]
    {
        for f in [0, 2 - width as i32, -1, 1, 4, 12, 4 * max_level as i32 + 1] {
            let Ok(core) = LoopFd::new(width, f, max_level) else { continue };
            for level in 0..=max_level.min(4) {
                (0..6).for_each(|_| assert_same(&core, level, &random_points(&mut random, &core, level)));
            }
        }
    }
}

#[test]
fn fast_and_slow_agree_at_every_level() {
    let mut random = Random(2);
    // 64-bit words with multiplication, with division, and 128-bit words
    for (width, f) in [(20, 0), (20, 20), (32, 2)] {
        let core = LoopFd::new(width, f, 10).unwrap();
        (5..=10).for_each(|level| assert_same(&core, level, &random_points(&mut random, &core, level)));
    }
}

#[test]
fn beats_of_level_one_by_hand() {
    // P4 = 12 alone: N00 = 12 * 16 * p with p = 12/192 * (96 at corner 0, 27 at two edge middles, ...)
    let core = LoopFd::new(8, 0, 1).unwrap();
    let mut points = [[0; 3]; 12];
    points[4] = [12, -12, 0];
    let [corner, middle, far] = [[6, -6, 0], [4, -4, 0], [1, -1, 0]];
    let beat =
        |left, right| Beat { left, right, strip_end: right.is_none(), patch_start: false, patch_end: false };
    let mut expected = vec![
        beat(corner, Some(middle)),
        beat(middle, Some([2, -2, 0])),
        beat(far, None),
        beat(middle, Some(far)),
        beat([2, -2, 0], None),
    ];
    expected[0].patch_start = true;
    expected[4].patch_end = true;
    assert_eq!(core.beats(1, &points).unwrap(), expected);
}

#[test]
fn one_triangle_packets_return_their_limit_positions() {
    let core = LoopFd::new(12, 0, 3).unwrap();
    let mut points = [[0; 3]; 12];
    let limits = [[-1000, 7, 2047], [3, 4, 5], [-2048, 0, 1]];
    for (index, limit) in [0, 2, 10].into_iter().zip(limits) {
        points[index] = limit.map(|x: i64| i128::from(x) * 12 * 16i128.pow(3));
    }
    let beats = core.beats(0, &points).unwrap();
    assert_eq!(beats.len(), 2);
    assert_eq!((beats[0].left, beats[0].right), (limits[0], Some(limits[1])));
    assert_eq!((beats[1].left, beats[1].right), (limits[2], None));
}

#[test]
fn numbers_no_core_can_have_are_refused() {
    assert!(LoopFd::new(1, 0, 3).is_err() && LoopFd::new(33, 0, 3).is_err());
    assert!(LoopFd::new(24, 0, 11).is_err());
    assert!(LoopFd::new(24, 26, 6).is_err() && LoopFd::new(24, 25, 6).is_ok());
    assert!(LoopFd::new(24, -23, 6).is_err() && LoopFd::new(24, -22, 6).is_ok());
    assert!(LoopFd::new(24, 0, 3).unwrap().beats(4, &[[0; 3]; 12]).is_err());
}

#[test]
fn whole_meshes_come_out_as_sample_by_sample() {
    // words of 64 bits with multiplication and division, of 128 bits, and a level below the maximum
    for (width, f, level, max_level) in [(16, 3, 3, 3), (24, 20, 2, 6), (32, 0, 2, 10), (24, -4, 4, 4)] {
        let core = LoopFd::new(width, f, max_level).unwrap();
        let table = Table::for_width(width).unwrap();
        let mut vertices = Vec::new();
        for (name, triangles) in zoo() {
            let mesh = shaken(triangles, width, 21);
            let counts = render(&mesh, level, &core, &table, &mut vertices).unwrap();
            let mut expected = Vec::new();
            let slow = patches(&mesh, level, max_level, &table, |patch| {
                let n = patch.steps() as u32;
                let places = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
                expected.extend(places.map(|(i, j)| direct::vertex(&core, patch.level, &patch.points, i, j)));
            });
            assert_eq!(Ok(counts), slow);
            assert!(vertices == expected, "{name}, {core:?}");
        }
    }
}

#[test]
fn beats_and_masks_agree_on_whole_meshes() {
    let core = LoopFd::new(16, 2, 3).unwrap();
    let table = Table::for_width(16).unwrap();
    for (name, triangles) in zoo() {
        let mesh = shaken(triangles, 16, 22);
        let expected = assembled(&mesh, 3, 3, &table, 2).positions().unwrap();
        let grid = subdiv_rtl::surface::fine_grid::FineGrid::new(&mesh, 3).unwrap();
        patches(&mesh, 3, 3, &table, |patch| {
            let (mut i, mut j) = (0, 0);
            core.for_each_beat(patch.level, &patch.points, |beat| {
                let at = |i, j| {
                    let [u, v] = patch.lattice(i, j).map(|x| x as usize);
                    expected[grid.vertex(patch.face as usize, u, v)]
                };
                assert_eq!(beat.left, at(i, j), "{name}");
                assert_eq!(beat.right, (!beat.strip_end).then(|| at(i + 1, j)), "{name}");
                (i, j) = if beat.strip_end { (i + 1, 0) } else { (i, j + 1) };
            })
            .unwrap();
        })
        .unwrap();
    }
}

#[test]
fn coordinates_that_are_wider_than_the_core_are_refused() {
    let mesh = shaken(surface_meshes::tetrahedron(), 16, 1);
    let (core, table) = (LoopFd::new(12, 0, 3).unwrap(), Table::for_width(12).unwrap());
    assert!(render(&mesh, 2, &core, &table, &mut Vec::new()).is_err());
}
