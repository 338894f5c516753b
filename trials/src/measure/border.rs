//! Border between exposed and unexposed pixels as a set of points, and the distance of other places from it.

use glam::DVec2;
use sdf_bake::PixelGrid;

/// Side of a cell in which pieces are looked up [pixels].
const CELL_SIDE: usize = 4;

/// Border of the region in which a field is positive.
#[derive(Clone, Debug)]
pub struct Border {
    /// Straight pieces: the crossings themselves, and one or two pieces in each square of four neighbouring pixels that
    /// the border crosses.
    pieces: Vec<[DVec2; 2]>,
    crossings: usize,
    /// Numbers of the pieces by cell, x running fastest; a piece is in the cell of its first end.
    cells: Vec<Vec<u32>>,
    /// Pixels of the field; a cell has [`CELL_SIDE`] of them along each side.
    pixels: PixelGrid,
}

/// A place relative to a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderDistance {
    /// Signed distance to the border [m], positive where the field is.
    pub distance: f64,
    /// Direction in which the distance increases; zero on the border and out of reach.
    pub away: DVec2,
    /// Nearest point of the border, if one is within reach.
    pub nearest: Option<DVec2>,
}

impl Border {
    /// Traces the zero level of a field by marching squares (Lorensen and Cline 1987, in the plane). The field has one
    /// value per pixel, NaN where it is unknown.
    pub fn new(field: &[f64], pixels: PixelGrid) -> Self {
        let crossing = |[a, b]: [(usize, usize); 2]| {
            let [from, to] = [a, b].map(|(i, j)| field[pixels.at(i, j)]);
            let crosses = from.is_finite() && to.is_finite() && (from > 0.0) != (to > 0.0);
            crosses.then(|| pixels.position(a.0, a.1).lerp(pixels.position(b.0, b.1), from / (from - to)))
        };
        let places = |right: usize, up: usize| {
            let columns = pixels.nx.saturating_sub(right);
            (0..pixels.ny.saturating_sub(up)).flat_map(move |j| (0..columns).map(move |i| (i, j)))
        };
        let along = places(1, 0).filter_map(|(i, j)| crossing([(i, j), (i + 1, j)]));
        let across = places(0, 1).filter_map(|(i, j)| crossing([(i, j), (i, j + 1)]));
        // Crossings are pieces of no length: beside unknown pixels nothing joins them.
        let mut pieces: Vec<[DVec2; 2]> = along.chain(across).map(|place| [place; 2]).collect();
        let crossings = pieces.len();
        pieces.extend(places(1, 1).flat_map(|(i, j)| {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let values = corners.map(|(i, j)| field[pixels.at(i, j)]);
            let edges = std::array::from_fn(|k| crossing([corners[k], corners[(k + 1) % 4]]));
            pieces_between(edges, (values[0] > 0.0) == (values.iter().sum::<f64>() > 0.0))
        }));
        let mut border = Self { pieces: Vec::new(), crossings, cells: Vec::new(), pixels };
        let (nx, ny) = border.shape();
        border.cells = vec![Vec::new(); nx * ny];
        for (number, [from, _]) in pieces.iter().enumerate() {
            let (i, j) = border.cell_of(*from);
            let (i, j) = ((i.max(0) as usize).min(nx - 1), (j.max(0) as usize).min(ny - 1));
            border.cells[j * nx + i].push(number as u32);
        }
        Self { pieces, ..border }
    }

    /// Number of cells along x and y.
    fn shape(&self) -> (usize, usize) {
        (self.pixels.nx.div_ceil(CELL_SIDE), self.pixels.ny.div_ceil(CELL_SIDE))
    }

    /// Cell of a place, which may lie outside the grid.
    fn cell_of(&self, place: DVec2) -> (i64, i64) {
        let cell = ((place - self.pixels.origin) / (CELL_SIDE as f64 * self.pixels.pitch)).floor();
        (cell.x as i64, cell.y as i64)
    }

    /// Pieces in the ring of cells at a distance [cells] from a cell.
    fn ring(&self, (i, j): (i64, i64), distance: i64) -> impl Iterator<Item = u32> {
        let (nx, ny) = self.shape();
        let (nx, ny) = (nx as i64, ny as i64);
        let rows = (j - distance).max(0)..=(j + distance).min(ny - 1);
        rows.flat_map(move |row| {
            // Of the rows between the first and the last only both ends belong to the ring.
            let step = if (row - j).abs() == distance { 1 } else { 2 * distance };
            let columns = (i - distance..=i + distance).step_by(step as usize);
            columns.filter(move |column| (0..nx).contains(column)).map(move |column| (row * nx + column) as usize)
        })
        .flat_map(|cell| self.cells[cell].iter().copied())
    }

    /// Nearest point of the border within reach, from rings of cells outwards; the first of several.
    fn nearest(&self, place: DVec2, reach: f64) -> Option<DVec2> {
        let (cell, side) = (self.cell_of(place), CELL_SIDE as f64 * self.pixels.pitch);
        let mut best: Option<(f64, u32, DVec2)> = None;
        for distance in 0.. {
            // The place is somewhere in its own cell. A piece begins in its cell, and is shorter than two pixels.
            let nearer = (distance as f64 - 1.0) * side - 2.0 * self.pixels.pitch;
            if nearer >= best.map_or(reach, |best| best.0.sqrt()) {
                break;
            }
            let found = self.ring(cell, distance).map(|number| {
                let point = nearest_on(self.pieces[number as usize], place);
                (point.distance_squared(place), number, point)
            });
            best = best.into_iter().chain(found).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        best.map(|best| best.2).filter(|nearest| nearest.distance(place) < reach)
    }

    /// Number of pixel edges that the border crosses.
    pub fn crossings(&self) -> usize {
        self.crossings
    }

    /// Locates a place, whose side is known, relative to the border; distances are clamped to `reach` [m].
    pub fn distance_from(&self, place: DVec2, is_above: bool, reach: f64) -> BorderDistance {
        let sign = if is_above { 1.0 } else { -1.0 };
        let Some(nearest) = self.nearest(place, reach) else {
            return BorderDistance { distance: sign * reach, away: DVec2::ZERO, nearest: None };
        };
        let way = place - nearest;
        BorderDistance { distance: sign * way.length(), away: sign * way.normalize_or_zero(), nearest: Some(nearest) }
    }
}

/// Pieces of the border in a square, from the crossings of its four edges in turn. With four crossings the border
/// cuts off two opposite corners: the first and third if these differ from the square's centre.
fn pieces_between(edges: [Option<DVec2>; 4], first_is_like_centre: bool) -> Vec<[DVec2; 2]> {
    let crossed: Vec<DVec2> = edges.into_iter().flatten().collect();
    match crossed[..] {
        [a, b] => vec![[a, b]],
        [a, b, c, d] if first_is_like_centre => vec![[a, b], [c, d]],
        [a, b, c, d] => vec![[d, a], [b, c]],
        _ => Vec::new(),
    }
}

/// Nearest point of a straight piece.
fn nearest_on([from, to]: [DVec2; 2], place: DVec2) -> DVec2 {
    let way = to - from;
    let share = (place - from).dot(way) / way.length_squared();
    if share.is_finite() { from + share.clamp(0.0, 1.0) * way } else { from }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: PixelGrid = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 40, ny: 30 };

    fn field(value: impl Fn(DVec2) -> f64) -> Vec<f64> {
        (0..PIXELS.ny).flat_map(|j| (0..PIXELS.nx).map(move |i| PIXELS.position(i, j))).map(value).collect()
    }

    #[test]
    fn distances_from_a_slanted_line_are_exact() {
        let normal = DVec2::new(0.6, 0.8);
        let height = |place: DVec2| normal.dot(place) - 9.1e-3;
        let border = Border::new(&field(height), PIXELS);
        for place in [DVec2::new(7e-3, 6.2e-3), DVec2::new(6.1e-3, 7.3e-3), DVec2::new(9e-3, 4.6e-3)] {
            let found = border.distance_from(place, height(place) > 0.0, 5e-3);
            assert!((found.distance - height(place)).abs() < 1e-12, "{found:?} for {}", height(place));
            assert!(found.away.distance(normal) < 1e-6 || found.distance.abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn distances_from_a_circle_are_those_of_its_chords() {
        let (centre, radius) = (DVec2::new(9.7e-3, 7.2e-3), 4e-3);
        let height = |place: DVec2| radius - place.distance(centre);
        let border = Border::new(&field(height), PIXELS);
        // The sagitta of a chord as long as a pixel's diagonal.
        let sagitta = 2.0 * PIXELS.pitch * PIXELS.pitch / (8.0 * radius);
        for turn in 0..50 {
            let place = centre + 3.6e-3 * DVec2::from_angle(f64::from(turn));
            let found = border.distance_from(place, true, 5e-3);
            assert!((found.distance - 0.4e-3).abs() < 2.0 * sagitta, "{found:?}");
        }
    }

    #[test]
    fn the_nearest_of_all_pieces_is_found() {
        let waves = |place: DVec2| (place.x * 900.0).sin() * (place.y * 700.0).cos() - 0.3;
        let border = Border::new(&field(waves), PIXELS);
        assert!(border.pieces.len() > 200);
        for number in 0..2000 {
            let place = DVec2::new(number as f64 * 0.618_034 % 1.2 - 0.1, number as f64 * 0.414_214 % 1.2 - 0.1);
            let place = place * DVec2::new(20e-3, 15e-3);
            let squares = border.pieces.iter().map(|piece| nearest_on(*piece, place).distance_squared(place));
            let least = squares.fold(f64::INFINITY, f64::min).sqrt();
            for reach in [0.7e-3, 30e-3] {
                let found = border.nearest(place, reach).map(|nearest| nearest.distance(place));
                assert_eq!(found, Some(least).filter(|least| *least < reach), "at {place}");
            }
        }
    }

    #[test]
    fn a_crossing_beside_unknown_pixels_still_is_a_border() {
        let mut line = field(|place| place.x - 9.8e-3);
        line.iter_mut().enumerate().filter(|(at, _)| at / PIXELS.nx != 10).for_each(|(_, value)| *value = f64::NAN);
        let border = Border::new(&line, PIXELS);
        assert_eq!(border.crossings(), 1);
        let place = PIXELS.position(0, 10) + DVec2::new(10.5e-3, 0.0);
        let found = border.distance_from(place, true, 5e-3);
        assert!((found.distance - 0.7e-3 - PIXELS.position(0, 10).x).abs() < 1e-9, "{found:?}");
    }
}
