//! The triangles of a surface that no wall parts from some of them.

/// Return the triangles around some, breadth first, and their area.
///
/// across: for each side 3 f + e of the surface the one that is the same edge seen from the
/// neighbour, -1 at a border; crossed: the triangles of walls. It ends as soon as the area is more
/// than `most`.
pub fn flood(
    across: &[i32],
    crossed: &[bool],
    areas: &[f64],
    seeds: &[i32],
    most: f64,
) -> (Vec<i32>, f64) {
    let mut seen = crossed.to_vec();
    let mut found = Vec::with_capacity(seeds.len().max(64));
    for &seed in seeds {
        if !seen[seed as usize] {
            seen[seed as usize] = true;
            found.push(seed);
        }
    }
    let mut area = 0.0;
    let mut at = 0;
    while let Some(&triangle) = found.get(at) {
        let f = triangle as usize;
        at += 1;
        area += areas[f];
        if area > most {
            break;
        }
        for &other in &across[3 * f..3 * f + 3] {
            if other >= 0 && !seen[other as usize / 3] {
                seen[other as usize / 3] = true;
                found.push(other / 3);
            }
        }
    }
    (found, area)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_stops_at_walls_and_at_its_limit() {
        // A row of four triangles: side 3 f + 1 leads on, side 3 f back.
        let across = [-1, 3, -1, 1, 6, -1, 4, 9, -1, 7, -1, -1];
        let crossed = [false, false, false, true];
        let areas = [1.0, 2.0, 4.0, 8.0];
        let (found, area) = flood(&across, &crossed, &areas, &[1, 3, 1], 100.0);
        assert_eq!((found, area), (vec![1, 0, 2], 7.0));
        let (found, area) = flood(&across, &crossed, &areas, &[0], 1.5);
        assert_eq!((found, area), (vec![0, 1], 3.0));
    }
}
