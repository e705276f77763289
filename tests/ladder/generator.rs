//! Seeded random problems: a hall of cells with tables, clutter, a wall with a door, robots of three kinds, relays.

use std::fmt::Write;
use std::io;

use contract::{RandomStream, SampleValues, StageKind};
use model::{DiskFiles, Files, Problem, load_problem};

/// Edge of a cell (m): a table stands in its middle, and a robot can drive round it.
const CELL: f64 = 1.6;

/// How large a random problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// 1 to 3 robots, 1 to 4 objects.
    Small,
    /// 4 to 6 robots, 8 to 16 objects.
    Large,
}

/// The problem of a seed.
pub fn problem(size: Size, seed: u64) -> Problem {
    let text = text(size, seed);
    load_text(&text).unwrap_or_else(|error| panic!("random problem {size:?} {seed} is refused: {error:?}\n{text}"))
}

/// The text of a seed's problem, for a file in the folder of scenes.
pub fn text(size: Size, seed: u64) -> String {
    Hall::new(size, seed).text()
}

/// Loads a problem whose text is not on disk; robots are.
pub fn load_text(text: &str) -> Result<Problem, model::ProblemError> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/launch/scenes/unwritten.yaml");
    load_problem(&Unwritten { path, text }, path)
}

struct Unwritten<'a> {
    path: &'a str,
    text: &'a str,
}

impl Files for Unwritten<'_> {
    fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        if path == self.path { Ok(self.text.as_bytes().to_vec()) } else { DiskFiles.read(path) }
    }
}

/// A table with its region and the objects that stand on it at the start.
struct Table {
    at: [f64; 2],
    edge: f64,
    region: [f64; 2],
    stand_on_it: usize,
}

struct Robot {
    kind: &'static str,
    at: [f64; 2],
    /// Tables that a fixed arm reaches; a mobile one comes to all.
    reaches: Option<[usize; 2]>,
    pairs: String,
}

struct Hall {
    values: SampleValues,
    columns: usize,
    rows: usize,
    cells: Vec<[f64; 2]>,
    tables: Vec<Table>,
    robots: Vec<Robot>,
    fixed: String,
    movable: String,
}

impl Hall {
    fn new(size: Size, seed: u64) -> Self {
        let mut values = RandomStream::new(seed, StageKind::Composite, &["generator"], "problem").values(0);
        let (columns, rows) = match size {
            Size::Small => (3 + values.next_index(2), 3),
            Size::Large => (5, 4),
        };
        let middle = |i: usize, n: usize| (i as f64 + 0.5 - n as f64 / 2.0) * CELL;
        let cells = (0..columns * rows).map(|i| [middle(i % columns, columns), middle(i / columns, rows)]).collect();
        let (tables, robots) = (Vec::new(), Vec::new());
        let (fixed, movable) = (String::new(), String::new());
        let mut hall = Self { values, columns, rows, cells, tables, robots, fixed, movable };
        let (robots, objects, tables) = match size {
            Size::Small => {
                (1 + hall.values.next_index(3), 1 + hall.values.next_index(4), 2 + hall.values.next_index(2))
            }
            Size::Large => (4 + hall.values.next_index(3), 8 + hall.values.next_index(9), 5),
        };
        for _ in 0..tables {
            hall.table();
        }
        for _ in 0..robots {
            hall.robot();
        }
        hall.clutter();
        hall.wall();
        for object in 0..objects {
            hall.object(object);
        }
        hall
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.values.next_unit() * (high - low)
    }

    /// Takes a free cell.
    fn cell(&mut self) -> [f64; 2] {
        let index = self.values.next_index(self.cells.len());
        self.cells.swap_remove(index)
    }

    fn table(&mut self) {
        let (at, edge) = (self.cell(), self.between(0.3, 0.6));
        // Every fourth has room for one box only.
        let tiny = self.values.next_index(4) == 0;
        let region = if tiny { [0.09, 0.07] } else { [self.between(0.2, edge), self.between(0.2, edge)] };
        self.tables.push(Table { at, edge, region, stand_on_it: 0 });
    }

    fn robot(&mut self) {
        let at = self.cell();
        let kind = ["mm10", "mm10", "mm10s", "fa7"][self.values.next_index(4)];
        // A fixed arm has two tables of its own, to which others come, too.
        let reaches = (kind == "fa7").then(|| {
            [-0.58, 0.58].map(|aside| {
                let at = [at[0] + aside, at[1]];
                self.tables.push(Table { at, edge: 0.3, region: [0.25, 0.25], stand_on_it: 0 });
                self.tables.len() - 1
            })
        });
        self.robots.push(Robot { kind, at, reaches, pairs: String::new() });
    }

    /// Boxes in a random share of the cells that are left.
    fn clutter(&mut self) {
        let density = self.between(0.0, 0.5);
        for (index, at) in self.cells.clone().into_iter().enumerate() {
            let edge = self.between(0.2, 0.8);
            if self.values.next_unit() < density {
                let _ = writeln!(
                    self.fixed,
                    "  - {{name: clutter_{index}, shape: {{box: [{edge:.3}, {edge:.3}, 0.5]}}, pose: {{xyz: [{:.3}, {:.3}, \
                     0.25]}}}}",
                    at[0], at[1]
                );
            }
        }
    }

    /// In half of the halls a wall between two columns, with a door on the line between two rows.
    fn wall(&mut self) {
        let (width, row) = (self.between(0.75, 1.6), 1 + self.values.next_index(self.rows - 1));
        let column = 1 + self.values.next_index(self.columns - 1);
        if self.values.next_index(2) == 0 {
            return;
        }
        let half = self.rows as f64 * CELL / 2.0;
        let x = column as f64 * CELL - self.columns as f64 * CELL / 2.0;
        let door = row as f64 * CELL - half;
        for (name, low, high) in [("south", -half, door - width / 2.0), ("north", door + width / 2.0, half)] {
            let _ = writeln!(
                self.fixed,
                "  - {{name: wall_{name}, shape: {{box: [0.1, {:.3}, 1.0]}}, pose: {{xyz: [{x:.3}, {:.3}, 0.5]}}}}",
                high - low,
                f64::midpoint(low, high)
            );
        }
    }

    /// An object on a table, with one hop or two: the second is another robot's, perhaps.
    fn object(&mut self, object: usize) {
        let robot = self.values.next_index(self.robots.len());
        let Some(from) = self.table_for(robot, &[]) else { return };
        let Some(to) = self.table_for(robot, &[from]) else { return };
        let table = &mut self.tables[from];
        let Some([x, y]) = table.free_place() else { return };
        let _ = writeln!(
            self.movable,
            "  - {{name: m{object}, shape: {{box: [0.07, 0.05, 0.15]}}, pose: {{xyz: [{x:.4}, {y:.4}, 0.675]}}}}"
        );
        self.pair(robot, object, from, to);
        let next = self.values.next_index(self.robots.len());
        let relayed = self.values.next_index(3) == 0 && self.robots[next].comes_to(to);
        if relayed && let Some(last) = self.table_for(next, &[from, to]) {
            self.pair(next, object, to, last);
        }
    }

    fn table_for(&mut self, robot: usize, but: &[usize]) -> Option<usize> {
        let open: Vec<usize> =
            (0..self.tables.len()).filter(|t| !but.contains(t) && self.robots[robot].comes_to(*t)).collect();
        (!open.is_empty()).then(|| open[self.values.next_index(open.len())])
    }

    fn pair(&mut self, robot: usize, object: usize, from: usize, to: usize) {
        let _ = writeln!(self.robots[robot].pairs, "    - {{object: m{object}, from: t{from}, to: t{to}}}");
    }

    fn text(&self) -> String {
        let [x, y] = [self.columns, self.rows].map(|n| n as f64 * CELL / 2.0);
        let mut text = String::from("robots:\n");
        for (index, Robot { kind, at, .. }) in self.robots.iter().enumerate() {
            let _ =
                writeln!(text, "  - name: r{index}\n    urdf: ../robots/{kind}.urdf\n    srdf: ../robots/{kind}.srdf");
            let _ = match *kind {
                "fa7" => writeln!(text, "    tool: tool\n    pose: {{xyz: [{:.3}, {:.3}, 0.0]}}", at[0], at[1]),
                _ => writeln!(
                    text,
                    "    tool: tool\n    base: {{x: [{:.3}, {x:.3}], y: [{:.3}, {y:.3}], speed: 0.8, yaw_rate: 1.5}}\n    \
                     start: {{x: {:.3}, y: {:.3}, yaw: 0.0}}",
                    -x, -y, at[0], at[1]
                ),
            };
        }
        text += "\nfixed:\n";
        for (index, Table { at, edge, .. }) in self.tables.iter().enumerate() {
            let _ = writeln!(
                text,
                "  - {{name: table_{index}, shape: {{box: [{edge:.3}, {edge:.3}, 0.6]}}, pose: {{xyz: [{:.3}, {:.3}, 0.3]}}}}",
                at[0], at[1]
            );
        }
        let _ = write!(text, "{}\nmovable:\n{}\nregions:\n", self.fixed, self.movable);
        for (index, Table { region, .. }) in self.tables.iter().enumerate() {
            let _ =
                writeln!(text, "  - {{name: t{index}, on: table_{index}, size: [{:.3}, {:.3}]}}", region[0], region[1]);
        }
        text += "\ntask:\n";
        for (index, robot) in self.robots.iter().enumerate().filter(|(_, robot)| !robot.pairs.is_empty()) {
            let _ = write!(text, "  r{index}:\n{}", robot.pairs);
        }
        text + "\nlevels: {highest: 0}\n"
    }
}

impl Robot {
    fn comes_to(&self, table: usize) -> bool {
        self.reaches.is_none_or(|own| own.contains(&table))
    }
}

impl Table {
    /// The next place on a grid over the region: hands fit between neighbours.
    fn free_place(&mut self) -> Option<[f64; 2]> {
        let counts = self.region.map(|edge| 1 + ((edge - 0.09) / 0.16).max(0.0) as usize);
        let index = self.stand_on_it;
        if index >= counts[0] * counts[1] {
            return None;
        }
        self.stand_on_it += 1;
        let place = [index % counts[0], index / counts[0]];
        Some(std::array::from_fn(|i| {
            // The table's edges are written with three digits.
            (self.at[i] * 1e3).round() / 1e3 + (place[i] as f64 - (counts[i] - 1) as f64 / 2.0) * 0.16
        }))
    }
}
