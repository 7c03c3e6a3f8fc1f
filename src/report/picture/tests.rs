//! Whole pictures of a torus and of a half sphere, small enough to be drawn in no time.

use super::*;
use glam::DVec3;

type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

/// A torus around the y axis, from `n` by `n` squares.
fn torus(n: u32) -> Mesh {
    let angle = |k: u32| f64::from(k) / f64::from(n) * std::f64::consts::TAU;
    let point = |i: u32, j: u32| {
        let r = 1.0 + 0.4 * angle(j).cos();
        DVec3::new(r * angle(i).cos(), 0.4 * angle(j).sin(), -r * angle(i).sin())
    };
    let positions = (0..n * n).map(|k| point(k / n, k % n)).collect();
    let at = |i: u32, j: u32| i % n * n + j % n;
    let squares = (0..n * n).map(|k| (k / n, k % n));
    let halves =
        |(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    (positions, squares.flat_map(halves).collect())
}

fn scene((positions, triangles): &Mesh) -> Scene<'_> {
    Scene { positions, triangles, normals: Normals::Smooth, colouring: Colouring::Plain, control: None }
}

fn small() -> Options {
    Options { width: 160, height: 120, ..Options::default() }
}

fn hash(image: &Image) -> String {
    blake3::hash(image.pixels.as_flattened()).to_hex()[..16].to_string()
}

/// How many pixels the test holds for.
fn count(image: &Image, test: impl Fn([i32; 3]) -> bool) -> usize {
    image.pixels.iter().filter(|pixel| test(pixel.map(i32::from))).count()
}

fn reddish([red, green, blue]: [i32; 3]) -> bool {
    red > green + 30 && red > blue + 30
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_machine() {
    let mesh = torus(24);
    let draw = |finish, threads| {
        hash(&render(&scene(&mesh), &Options { finish, threads: Some(threads), ..small() }).unwrap())
    };
    for (finish, bytes) in
        [(Finish::Studio, "acb103be0f181bf0"), (Finish::ReflectionLines, "900947781c7b178c")]
    {
        for threads in [1, 2, 5] {
            // Written once on x86-64. It changes with every change of the looks, and with nothing else.
            assert_eq!(draw(finish, threads), bytes, "{finish:?} on {threads} threads");
        }
    }
}

#[test]
fn the_key_lamp_stands_at_the_upper_left() {
    let (directions, triangles) = torus(24);
    // The same connectivity shrunk to a small ball: light depends on the normal only.
    let positions: Vec<DVec3> = directions.iter().map(|d| d.normalize()).collect();
    let ball = (positions.clone(), triangles);
    let scene = Scene { normals: Normals::Given(&positions), ..scene(&ball) };
    let image = render(&scene, &small()).unwrap();
    let at = |x: usize, y: usize| image.pixels[y * 160 + x].map(i32::from).iter().sum::<i32>();
    assert!(at(62, 40) > at(100, 85) + 60, "{} {}", at(62, 40), at(100, 85));
}

#[test]
fn the_inside_of_an_open_surface_is_terracotta() {
    let (positions, triangles) = torus(24);
    let closed = render(&scene(&(positions.clone(), triangles.clone())), &small()).unwrap();
    assert_eq!(count(&closed, reddish), 0);
    // Cut the upper half of the tube away and look into it.
    let low = |t: &[u32; 3]| t.iter().all(|&k| positions[k as usize].y < 0.05);
    let gutter: Vec<[u32; 3]> = triangles.into_iter().filter(low).collect();
    let open = render(&scene(&(positions, gutter)), &small()).unwrap();
    assert!(count(&open, reddish) > 500, "{}", count(&open, reddish));
}

#[test]
fn the_control_mesh_is_drawn_over_the_surface() {
    let mesh = torus(24);
    let positions: Vec<DVec3> = mesh.0.iter().map(|p| *p * 1.1).collect();
    let edges: Vec<[u32; 2]> = mesh.1.iter().map(|t| [t[0], t[1]]).collect();
    let control = Some(Wire { positions: &positions, edges: &edges });
    let with = render(&Scene { control, ..scene(&mesh) }, &small()).unwrap();
    assert!(count(&with, |[red, _, blue]| red > blue) > 500);
}

#[test]
fn patches_are_told_apart_and_their_borders_drawn() {
    let mesh = torus(24);
    let patches: Vec<Patch> = (0..mesh.1.len() as u32)
        .map(|k| Patch { depth: 4 * u8::from(k % 96 < 48), number: k / 48 })
        .collect();
    let scene = Scene { colouring: Colouring::Patches(&patches), ..scene(&mesh) };
    let image = render(&scene, &small()).unwrap();
    let green = |[red, green, blue]: [i32; 3]| green > red + 25 && green > blue + 25;
    let coloured = count(&image, green);
    assert!((800..5000).contains(&coloured), "{coloured}");
    assert_eq!(groups::borders(&mesh.1, &patches).len(), 24 * 24);
}

#[test]
fn strips_have_colours_of_their_own_and_no_legend() {
    let mesh = torus(24);
    // Bands of four squares around the tube.
    let strips: Vec<u32> = (0..mesh.1.len() as u32).map(|k| k / 48 / 4).collect();
    let image = render(&Scene { colouring: Colouring::Strips(&strips), ..scene(&mesh) }, &small()).unwrap();
    let one =
        render(&Scene { colouring: Colouring::Strips(&vec![3; strips.len()]), ..scene(&mesh) }, &small());
    let warm = |[red, _, blue]: [i32; 3]| red > blue + 40;
    let cold = |[red, _, blue]: [i32; 3]| blue > red + 25;
    assert!(count(&image, warm) > 300 && count(&image, cold) > 300);
    assert_eq!(count(&one.unwrap(), warm) + count(&image, |[r, g, b]| r.max(g).max(b) < 5), 0);
    assert_eq!(groups::borders(&mesh.1, &strips).len(), 6 * 24);
}

#[test]
fn the_heat_map_has_a_legend() {
    let mesh = torus(24);
    let values = vec![0.0; mesh.0.len()];
    let colouring = Colouring::Values { values: &values, range: [0.0, 0.5], title: "error (lsb)" };
    let image = render(&Scene { colouring, ..scene(&mesh) }, &small()).unwrap();
    // All values are 0, so only the legend shows the other colours.
    let seen: Vec<usize> =
        (0..160).filter(|x| (0..120).any(|y| reddish(image.pixels[y * 160 + x].map(i32::from)))).collect();
    assert!(!seen.is_empty() && seen.iter().all(|x| *x > 140), "{seen:?}");
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let good = torus(4);
    let message = |scene: &Scene| render(scene, &small()).unwrap_err().what;
    assert_eq!(message(&scene(&(good.0.clone(), vec![]))), "a picture of no triangles");
    let broken = (good.0.clone(), vec![[0, 1, 16]]);
    assert_eq!(message(&scene(&broken)), "triangle 0 names a point that does not exist");
    let mut nan = good.clone();
    nan.0[3].y = f64::NAN;
    assert_eq!(message(&scene(&nan)), "position 3 is no finite number");
    let values = [0.0; 3];
    let colouring = Colouring::Values { values: &values, range: [0.0, 1.0], title: "" };
    assert_eq!(message(&Scene { colouring, ..scene(&good) }), "3 values for 16 positions");
    assert!(render(&scene(&good), &Options { width: 0, ..small() }).is_err());
}

#[test]
fn a_single_point_and_huge_numbers_are_no_trouble() {
    let triangles = vec![[0, 1, 2]];
    assert!(render(&scene(&(vec![DVec3::ONE; 3], triangles.clone())), &small()).is_ok());
    let huge = [[1e300, 0.0, 0.0], [0.0, 1e300, 0.0], [0.0, 0.0, -1e300]].map(DVec3::from).to_vec();
    assert!(render(&scene(&(huge, triangles)), &small()).is_ok());
}
