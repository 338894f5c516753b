//! Parity of the kernel `sample` with its CPU twin, and both against closed forms.

use shaders::constants::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE};
use shaders::testing::device;
use shaders::{GridBuffers, GridError, GridHeader, SELF_CHECK_LIMIT, SampleError, Sampler, self_check};

const VOXEL: f32 = 0.0005;
const ORIGIN: [i32; 3] = [-2, -1, -3];
const DIMS: [u32; 3] = [4, 3, 5];

/// Reproducible random numbers from 0 to 1 (Park & Miller 1988).
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> f32 {
        self.0 = self.0 * 48_271 % 0x7fff_ffff;
        self.0 as f32 / 0x7fff_ffff as f32
    }
}

struct Grid {
    header: GridHeader,
    index: Vec<u32>,
    phi: Vec<f32>,
}

impl Grid {
    /// Bricks whose values come from `phi` [m] at voxel coordinates; with `gaps`, every fourth brick is OUTSIDE and
    /// every fourth INSIDE.
    fn new(band: f32, gaps: bool, mut phi: impl FnMut([f32; 3]) -> f32) -> Self {
        let [nx, ny, nz] = DIMS.map(|n| n as i32);
        let mut grid = Self { header: GridHeader::new(ORIGIN, DIMS, VOXEL, band, 0), index: vec![], phi: vec![] };
        for entry in 0..nx * ny * nz {
            let code = if gaps { entry * 7 % 4 } else { 0 };
            if code >= 2 {
                grid.index.push(if code == 2 { OUTSIDE } else { INSIDE });
                continue;
            }
            let brick = [entry / (ny * nz) + ORIGIN[0], entry / nz % ny + ORIGIN[1], entry % nz + ORIGIN[2]];
            grid.index.push(grid.header.bricks);
            grid.header.bricks += 1;
            for offset in 0..BRICK_VOXELS as i32 {
                let local = [offset >> 6, offset >> 3 & 7, offset & 7];
                grid.phi.push(phi(std::array::from_fn(|a| (brick[a] * BRICK_SIDE as i32 + local[a]) as f32)));
            }
        }
        // The pool in a different order from the index, as after bricks are added.
        let bricks = grid.header.bricks;
        let turned = bricks as usize / 2 * BRICK_VOXELS as usize;
        grid.phi.rotate_left(turned);
        for slot in grid.index.iter_mut().filter(|slot| **slot < bricks) {
            *slot = (*slot + bricks - bricks / 2) % bricks;
        }
        grid
    }

    fn buffers(&self) -> GridBuffers<'_> {
        GridBuffers { header: self.header, index: &self.index, phi: &self.phi }
    }
}

/// Points in the indexed box and beyond it: anywhere, on voxels and brick borders, and very close to them.
fn points(seed: u64) -> Vec<[f32; 4]> {
    let mut stream = Stream(seed);
    let mut points = Vec::new();
    for i in 0..20_000 {
        let mut at = [0.0; 4];
        for axis in 0..3 {
            let low = ((ORIGIN[axis] - 1) * BRICK_SIDE as i32) as f32;
            let anywhere = low + stream.next() * ((DIMS[axis] + 2) * BRICK_SIDE) as f32;
            let border = (anywhere / BRICK_SIDE as f32).round() * BRICK_SIDE as f32;
            at[axis] = VOXEL
                * match i % 5 {
                    0 => anywhere.round(),
                    1 => border,
                    2 => border - 1e-4,
                    3 => border - 1.0 + stream.next(),
                    _ => anywhere,
                };
        }
        points.push(at);
    }
    points
}

/// Largest difference between kernel and twin [voxels].
fn parity(sampler: &Sampler<'_>, grid: &Grid, points: &[[f32; 4]]) -> f32 {
    let sampled = sampler.sample(points).expect("sampled");
    assert_eq!(sampled.len(), points.len());
    let mut worst = 0.0f32;
    for (&[x, y, z, w], &phi) in points.iter().zip(&sampled) {
        let expected = grid.buffers().sample_phi([x, y, z]);
        let difference = (phi - expected).abs() / VOXEL;
        assert!(difference <= SELF_CHECK_LIMIT, "at {:?}: {phi}, expected {expected}", [x, y, z, w]);
        worst = worst.max(difference);
    }
    worst
}

#[test]
fn random_fields_with_gaps_are_sampled_as_the_twin_samples_them() {
    let Some(device) = device("parity of the kernel `sample` on random fields") else { return };
    for seed in 1..=4 {
        let mut stream = Stream(seed * 977);
        // Half a voxel either way: no difference between neighbours exceeds that of a distance.
        let grid = Grid::new(0.5 * VOXEL, true, |_| (stream.next() - 0.5) * VOXEL);
        assert_eq!(grid.buffers().validate(), Ok(()));
        let sampler = Sampler::new(&device, &grid.buffers()).expect("a sampler");
        let worst = parity(&sampler, &grid, &points(seed * 31));
        println!("seed {seed}: largest difference {worst:e} voxels");
    }
}

#[test]
fn a_linear_field_is_reproduced_on_both_sides() {
    let plane = |[x, y, z]: [f32; 3]| VOXEL * (0.5 * x - 0.25 * y + 0.125 * z + 0.75);
    let grid = Grid::new(1.0, false, plane);
    let (low, high) = ([-16.0, -8.0, -24.0], [15.0, 15.0, 15.0]);
    let within = |p: &[f32; 4]| (0..3).all(|a| p[a] >= low[a] * VOXEL && p[a] <= high[a] * VOXEL);
    let points: Vec<_> = points(5).into_iter().filter(within).collect();
    assert!(points.len() > 1000);
    let check = |side: &str, phi: f32, p: [f32; 4]| {
        let exact = plane([p[0] / VOXEL, p[1] / VOXEL, p[2] / VOXEL]);
        assert!((phi - exact).abs() <= 2e-5 * VOXEL, "{side} says {phi} at {p:?}, the plane {exact}");
    };
    for &p in &points {
        check("the twin", grid.buffers().sample_phi([p[0], p[1], p[2]]), p);
    }
    let Some(device) = device("the kernel `sample` on a linear field") else { return };
    let sampled = Sampler::new(&device, &grid.buffers()).unwrap().sample(&points).unwrap();
    for (&p, &phi) in points.iter().zip(&sampled) {
        check("the kernel", phi, p);
    }
}

#[test]
fn far_and_senseless_points_read_the_band_and_nan_on_both_sides() {
    let grid = Grid::new(0.003, true, |_| 0.001);
    let far = [1.0, -1e3, 1e9, -3e38, f32::MAX];
    let bad = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let points: Vec<[f32; 4]> =
        far.iter().chain(&bad).flat_map(|&x| [[x, 0.0, 0.0, 0.0], [0.0, 0.0, x, 0.0]]).collect();
    let check = |side: &str, phi: &[f32]| {
        let (at_far, at_bad) = phi.split_at(2 * far.len());
        assert!(at_far.iter().all(|&phi| phi == 0.003), "{side}: {at_far:?}");
        assert!(at_bad.iter().all(|phi| phi.is_nan()), "{side}: {at_bad:?}");
    };
    check("the twin", &points.iter().map(|&[x, y, z, _]| grid.buffers().sample_phi([x, y, z])).collect::<Vec<_>>());
    let Some(device) = device("the kernel `sample` at far and senseless points") else { return };
    check("the kernel", &Sampler::new(&device, &grid.buffers()).unwrap().sample(&points).unwrap());
}

#[test]
fn an_empty_grid_and_an_empty_list_are_sampled() {
    let Some(device) = device("the kernel `sample` on nothing") else { return };
    let empty = GridBuffers { header: GridHeader::new([0; 3], [0; 3], VOXEL, 0.001, 0), index: &[], phi: &[] };
    let sampler = Sampler::new(&device, &empty).expect("a sampler");
    assert_eq!(sampler.sample(&[]).unwrap(), [0.0; 0]);
    assert_eq!(sampler.sample(&[[0.0; 4]]).unwrap(), [0.001]);
}

#[test]
fn more_points_than_one_dispatch_takes_are_all_sampled_in_order() {
    let Some(device) = device("the kernel `sample` on more points than one dispatch takes") else { return };
    let grid = Grid::new(1.0, false, |[x, ..]| x * VOXEL);
    let count = 65_535 * shaders::constants::WORKGROUP_SIZE as usize + 1000;
    let points: Vec<[f32; 4]> = (0..count).map(|i| [(i % 29) as f32 * 0.5 * VOXEL, 0.0, 0.0, 0.0]).collect();
    let sampled = Sampler::new(&device, &grid.buffers()).unwrap().sample(&points).unwrap();
    assert_eq!(sampled.len(), count);
    let wrong = (0..count).find(|&i| (sampled[i] - points[i][0]).abs() > 1e-4 * VOXEL);
    assert_eq!(wrong, None);
}

#[test]
fn the_self_check_passes() {
    let Some(device) = device("the self-check") else { return };
    let worst = self_check(&device).expect("a self-check");
    println!("self-check on {}: {worst:e} voxels", device.adapter());
    assert!(worst < SELF_CHECK_LIMIT);
}

#[test]
fn a_pool_larger_than_the_binding_limit_is_a_named_error() {
    let Some(device) = device("the refusal of a pool that is too large") else { return };
    let limits = device.adapter().limits;
    let limit = limits.storage_binding_bytes.min(limits.buffer_bytes);
    if limit > 1 << 29 {
        eprintln!("NOT TESTED: the refusal of a pool larger than {limit} bytes, more than this test may take");
        return;
    }
    let brick_bytes = u64::from(BRICK_VOXELS) * 4;
    let bricks = (limit / brick_bytes + 1) as u32;
    let phi = vec![0.0; (bricks * BRICK_VOXELS) as usize];
    let header = GridHeader::new([0; 3], [1; 3], VOXEL, 0.001, bricks);
    match Sampler::new(&device, &GridBuffers { header, index: &[0], phi: &phi }) {
        Err(SampleError::TooLarge { array: "pool", bytes, limit: named, .. }) => {
            assert_eq!((bytes, named), (u64::from(bricks) * brick_bytes, limit));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn arrays_that_disagree_with_the_header_are_named() {
    let grid = Grid::new(0.001, true, |_| 0.0);
    let bricks = grid.header.bricks;
    let with = |header: GridHeader| GridBuffers { header, ..grid.buffers() }.validate();
    assert!(matches!(with(GridHeader { voxel: f32::NAN, ..grid.header }), Err(GridError::Length { .. })));
    assert!(matches!(with(GridHeader { band: 0.0, ..grid.header }), Err(GridError::Length { .. })));
    assert!(matches!(with(GridHeader { dims: [4, 3, 4, 0], ..grid.header }), Err(GridError::Index { .. })));
    assert!(matches!(with(GridHeader { origin: [1 << 20, 0, 0, 0], ..grid.header }), Err(GridError::Far { .. })));
    assert!(matches!(with(GridHeader { bricks: bricks - 1, ..grid.header }), Err(GridError::Pool { .. })));
    let mut index = grid.index.clone();
    index[0] = bricks;
    let wrong = GridBuffers { index: &index, ..grid.buffers() }.validate();
    assert_eq!(wrong, Err(GridError::Slot { entry: 0, slot: bricks, bricks }));
}
