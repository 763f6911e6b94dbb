//! Grids of quads, and the arrays of a bench and a census, for the tests of this crate.

use patterndb_core::code::Reading;
use patterndb_core::halfedge::fans;
use patterndb_core::reduction::ReductionWork;

use crate::census::{Bench, Census, KernelMesh, Stars, list_stars};
use crate::hashing::{Key, KeyMap, Table, random_pairs};

/// A grid of quads, as a mesh.
pub struct Grid {
    twin: Vec<[i32; 4]>,
    vertex: Vec<[i32; 4]>,
    stars: Stars,
    zobrist: Vec<Key>,
}

impl Grid {
    /// Return a grid whose quad `row * columns + column` has the quad below at its edge 0, then
    /// those to the right, above and to the left.
    pub fn new(rows: i32, columns: i32) -> Self {
        let mut twin = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let quad = row * columns + column;
                let neighbour = |is_there: bool, step: i32, edge: i32| {
                    if is_there {
                        4 * (quad + step) + edge
                    } else {
                        -1
                    }
                };
                twin.push([
                    neighbour(row > 0, -columns, 2),
                    neighbour(column + 1 < columns, 1, 3),
                    neighbour(row + 1 < rows, columns, 0),
                    neighbour(column > 0, -1, 1),
                ]);
            }
        }
        let flat = twin.as_flattened();
        let (vertex, n_vertices) = fans(flat);
        Self {
            stars: list_stars(flat, &vertex, n_vertices as usize),
            vertex: vertex.as_chunks().0.to_vec(),
            zobrist: random_pairs(twin.len()),
            twin,
        }
    }

    pub fn mesh(&self) -> KernelMesh<'_> {
        KernelMesh {
            twin: &self.twin,
            vertex: &self.vertex,
            valence: &self.stars.valence,
            full: &self.stars.full,
            star_start: &self.stars.star_start,
            star: &self.stars.star,
            zobrist: &self.zobrist,
        }
    }
}

/// The arrays of a bench.
pub struct BenchArrays {
    of_quad: Vec<i32>,
    of_vertex: Vec<i32>,
    stamps: [Vec<i64>; 2],
    stamp: [i64; 2],
    rows: [Vec<[i32; 4]>; 2],
    code: Vec<u16>,
    curvature: i64,
    lists: [Vec<i32>; 9],
}

impl BenchArrays {
    pub fn new(mesh: &KernelMesh, limit: usize) -> Self {
        let n_vertices = mesh.full.len();
        let mut lists = std::array::from_fn(|_| vec![0; 4 * limit]);
        lists[8].fill(-1);
        Self {
            of_quad: vec![-1; mesh.twin.len()],
            of_vertex: vec![0; n_vertices],
            stamps: [vec![0; n_vertices], vec![0; n_vertices]],
            stamp: [0; 2],
            rows: [vec![[0; 4]; limit], vec![[0; 4]; limit]],
            code: vec![0; 4 * limit],
            curvature: 0,
            lists,
        }
    }

    pub fn bench(&mut self) -> Bench<'_> {
        let [gone, seen] = &mut self.stamps;
        let [twin, vertex] = &mut self.rows;
        let [
            quads,
            number,
            entry,
            order,
            border,
            head,
            reduced,
            starts,
            block,
        ] = &mut self.lists;
        Bench {
            member: &mut self.of_quad,
            held: &mut self.of_vertex,
            quads,
            twin,
            vertex,
            curvature: &mut self.curvature,
            code: &mut self.code,
            reading: Reading {
                number,
                entry,
                order,
            },
            work: ReductionWork {
                gone,
                seen,
                stamp: &mut self.stamp,
                border,
                block,
                head,
                reduced,
                starts,
            },
        }
    }
}

/// Return an empty census with room for one row.
pub fn small_census(used: &mut [i64; 4]) -> Census<'_> {
    Census {
        used,
        most: 8,
        readings: KeyMap::new(4),
        rows: KeyMap::new(4),
        codes: Table::Own(vec![0; 1]),
        ends: Table::Own(vec![0; 2]),
        sides: Table::Own(vec![0]),
        patches: Table::Own(vec![[0; 2]]),
        example_size: Table::Own(vec![0]),
        example_hash: Table::Own(vec![[0; 2]]),
        example_at: Table::Own(vec![0]),
        example: Table::Own(vec![0]),
    }
}
