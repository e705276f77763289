//! The enumeration against brute force over all samples and all ways to order their collisions.

use std::collections::BTreeSet;

use contract::Literal;
use model::{
    Body, EndEffector, EndPolicy, FixedId, GivenOrdering, Levels, LinkId, MovableObject, ObjectId, Pair, PairId, Point,
    Pose, Problem, Region, RegionId, Robot, RobotId, SearchSettings, Settings, Shape,
};
use skeleton::{Event, Occupancy, Skeleton};

use crate::bits::{self, BitRows};
use crate::enumeration::Enumeration;
use crate::layout::Layout;
use crate::network::{Overlaps, Stop};
use crate::nogoods::Nogoods;
use crate::order_sets::{OrderSets, Patience};
use crate::verdict::Judge;

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

fn robot(name: String) -> Robot {
    Robot {
        name,
        world_from_base: Pose::identity(),
        links: vec![],
        joints: vec![],
        coordinates: vec![],
        base: None,
        end_effector: EndEffector {
            name: "hand".into(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: vec![],
            max_opening: 0.1,
        },
        disabled_pairs: vec![],
        start: vec![],
        home: vec![],
        carry: vec![],
    }
}

/// Moves (robot, object) in an order in which they could all be made one after another.
fn problem(moves: &[(usize, usize)], robots: usize, objects: usize) -> Problem {
    let object = |i| MovableObject {
        name: format!("m{i}"),
        body: Body { owner_from_shape: Pose::identity(), shape: Shape::Box { size: [0.1; 3] } },
        world_from_start: Pose::identity(),
        start_support: None,
        grasps: vec![vec![]; robots],
    };
    let mut pairs: Vec<Pair> = Vec::new();
    for (i, (robot, object)) in moves.iter().enumerate() {
        let hop = moves[..=i].iter().filter(|(_, other)| other == object).count() as u32;
        let (robot, object) = (RobotId::at(*robot), ObjectId::at(*object));
        pairs.push(Pair { name: format!("move {i}"), robot, object, from: RegionId(0), to: RegionId(0), hop });
    }
    pairs.sort_by_key(|pair| pair.robot);
    Problem {
        name: "random".into(),
        robots: (0..robots).map(|i| robot(format!("r{i}"))).collect(),
        fixed: vec![],
        movable: (0..objects).map(object).collect(),
        regions: vec![Region {
            name: "w".into(),
            world_from_region: Pose::identity(),
            size: [1.0, 1.0],
            support: FixedId(0),
        }],
        pairs,
        orderings: vec![],
        end_policies: vec![EndPolicy::Return; robots],
        settings: Settings::default(),
        levels: Levels::default(),
        search: SearchSettings::default(),
    }
}

/// A problem with collisions listed: `collide[a][va][b][vb]`.
struct Instance {
    problem: Problem,
    skeleton: Skeleton,
    sizes: Vec<usize>,
    tables: Tables,
    nogoods: Vec<Vec<Literal>>,
}

struct Tables(Vec<Vec<Vec<Vec<u64>>>>);

impl Overlaps for Tables {
    fn row(&mut self, first: usize, value: usize, second: usize) -> Result<&[u64], Stop> {
        Ok(&self.0[first][value][second])
    }

    fn spend(&mut self, _: u64) -> Result<(), Stop> {
        Ok(())
    }
}

impl Instance {
    fn random(seed: u64) -> Self {
        let mut random = Random(seed);
        let (robots, objects) = (1 + random.below(3), 2 + random.below(3));
        let moves: Vec<(usize, usize)> =
            (0..1 + random.below(3)).map(|_| (random.below(robots), random.below(objects))).collect();
        let mut problem = problem(&moves, robots, objects);
        for _ in 0..random.below(3) {
            let mut end = || (PairId::at(random.below(moves.len())), [Point::Grasp, Point::Release][random.below(2)]);
            problem.orderings.push(GivenOrdering { before: end(), after: end() });
            if Skeleton::of_problem(&problem).is_err() {
                problem.orderings.pop();
            }
        }
        let skeleton = Skeleton::of_problem(&problem).unwrap();
        let size = |site: Occupancy, random: &mut Random| if site.hop == 0 { 1 } else { 1 + random.below(5) };
        let sizes: Vec<usize> = skeleton.occupancies().map(|site| size(site, &mut random)).collect();
        let density = 1 + random.below(10);
        let tables = Tables::random(&sizes, |random| random.below(10) < density, &mut random);
        let mut instance = Self { problem, skeleton, sizes, tables, nogoods: vec![] };
        instance.nogoods = (0..random.below(4)).map(|_| instance.nogood(&mut random)).collect();
        instance
    }

    fn nogood(&self, random: &mut Random) -> Vec<Literal> {
        let sites: Vec<Occupancy> = self.skeleton.occupancies().collect();
        let pairs = self.problem.pairs.len();
        (0..1 + random.below(3))
            .map(|_| match random.below(4) {
                0 => Literal::Order {
                    before: Event::grasp(PairId::at(random.below(pairs))),
                    after: Event::release(PairId::at(random.below(pairs))),
                },
                _ => Literal::Pose { occupancy: sites[random.below(sites.len())], sample: random.below(5) as u32 },
            })
            .collect()
    }

    /// All candidates in the order in which the enumeration gives them.
    fn enumerated(&mut self, patience: Patience) -> Vec<Candidate> {
        let layout = Layout::new(&self.problem, &self.skeleton, |_, _| true);
        let mut domains = BitRows::new(self.sizes.len(), 5);
        for (site, size) in self.sizes.iter().enumerate() {
            (0..*size).for_each(|value| bits::insert(domains.row_mut(site), value));
        }
        let nogoods = Nogoods::new(&self.nogoods, &layout, 5);
        let mut enumeration =
            Enumeration::new(OrderSets::new(Judge::new(&self.problem, &layout, &domains, nogoods), patience));
        let mut all = Vec::new();
        while let Some(solved) = enumeration.next(&mut self.tables).unwrap() {
            let events = |order: &usize| (layout.orders[*order].before, layout.orders[*order].after);
            all.push(Candidate { values: solved.values, orders: solved.orders.iter().map(events).collect() });
        }
        all
    }
}

impl Tables {
    fn random(sizes: &[usize], collides: impl Fn(&mut Random) -> bool, random: &mut Random) -> Self {
        let row = |size: &usize| vec![vec![vec![0]; sizes.len()]; *size];
        let mut tables = Self(sizes.iter().map(row).collect());
        for (a, b) in (0..sizes.len()).flat_map(|b| (0..b).map(move |a| (a, b))) {
            for (va, vb) in (0..sizes[a]).flat_map(|va| (0..sizes[b]).map(move |vb| (va, vb))) {
                if collides(random) {
                    tables.collide((a, va), (b, vb));
                }
            }
        }
        tables
    }

    fn collide(&mut self, (a, va): (usize, usize), (b, vb): (usize, usize)) {
        bits::insert(&mut self.0[a][va][b], vb);
        bits::insert(&mut self.0[b][vb][a], va);
    }

    fn meet(&self, (a, va): (usize, usize), (b, vb): (usize, usize)) -> bool {
        bits::contains(&self.0[a][va][b], vb)
    }
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    values: Vec<usize>,
    orders: Vec<(Event, Event)>,
}

/// The oracle's own closure over grasps and releases: `before[x][y]`.
#[derive(Clone)]
struct Before(Vec<Vec<bool>>);

impl Before {
    fn node(event: Event) -> usize {
        event.pair.index() * 2 + usize::from(event.point == Point::Release)
    }

    fn given(problem: &Problem) -> Self {
        let nodes = problem.pairs.len() * 2;
        let mut before = Self(vec![vec![false; nodes]; nodes]);
        for (i, pair) in problem.pairs.iter().enumerate() {
            before.0[2 * i][2 * i + 1] = true;
            for (j, other) in problem.pairs.iter().enumerate() {
                let next_of_robot = i < j && pair.robot == other.robot;
                let next_hop = pair.object == other.object && pair.hop < other.hop;
                before.0[2 * i + 1][2 * j] |= next_of_robot || next_hop;
            }
        }
        for ordering in &problem.orderings {
            let [x, y] = [ordering.before, ordering.after].map(|(pair, point)| Self::node(Event::new(pair, point)));
            before.0[x][y] = true;
        }
        before.closed()
    }

    fn closed(mut self) -> Self {
        let n = self.0.len();
        for k in 0..n {
            for x in 0..n {
                for y in 0..n {
                    self.0[x][y] |= self.0[x][k] && self.0[k][y];
                }
            }
        }
        self
    }

    fn with(&self, orders: &[(Event, Event)]) -> Self {
        let mut more = self.clone();
        orders.iter().for_each(|(x, y)| more.0[Self::node(*x)][Self::node(*y)] = true);
        more.closed()
    }

    fn holds(&self, x: Event, y: Event) -> bool {
        self.0[Self::node(x)][Self::node(y)]
    }

    fn is_cyclic(&self) -> bool {
        (0..self.0.len()).any(|x| self.0[x][x])
    }
}

struct Brute<'a> {
    instance: &'a Instance,
    given: Before,
    /// Release that begins and grasp that ends each site.
    ends: Vec<(Option<Event>, Option<Event>)>,
    objects: Vec<ObjectId>,
}

impl<'a> Brute<'a> {
    fn new(instance: &'a Instance) -> Self {
        let problem = &instance.problem;
        let of_hop = |object, hop| {
            let is_it = |pair: &Pair| pair.object == object && pair.hop == hop;
            problem.pairs.iter().position(is_it).map(PairId::at)
        };
        let sites: Vec<Occupancy> = instance.skeleton.occupancies().collect();
        let ends = sites.iter().map(|site| {
            (of_hop(site.object, site.hop).map(Event::release), of_hop(site.object, site.hop + 1).map(Event::grasp))
        });
        let objects = sites.iter().map(|site| site.object).collect();
        Self { instance, given: Before::given(problem), ends: ends.collect(), objects }
    }

    fn all(&self) -> Vec<Candidate> {
        let mut all = BTreeSet::new();
        self.each_values(&mut Vec::new(), &mut all);
        let mut all: Vec<Candidate> = all.into_iter().collect();
        let effort = |values: &[usize]| values.iter().map(|value| [0, 1, 2, 2, 3][*value]).sum::<u32>();
        all.sort_by_cached_key(|c| (c.orders.len(), effort(&c.values), c.values.clone(), c.orders.clone()));
        all
    }

    fn each_values(&self, values: &mut Vec<usize>, all: &mut BTreeSet<Candidate>) {
        let Some(size) = self.instance.sizes.get(values.len()) else {
            return self.each_order(values, all);
        };
        for value in 0..*size {
            values.push(value);
            self.each_values(values, all);
            values.pop();
        }
    }

    /// Whether the interval of `a` is over before that of `b` begins.
    fn parted(&self, before: &Before, a: usize, b: usize) -> bool {
        matches!((self.ends[a].1, self.ends[b].0), (Some(leaves), Some(comes)) if before.holds(leaves, comes))
    }

    fn each_order(&self, values: &[usize], all: &mut BTreeSet<Candidate>) {
        let mut collisions = Vec::new();
        for (a, b) in (0..values.len()).flat_map(|b| (0..b).map(move |a| (a, b))) {
            let placed = self.ends[a].0.is_some() || self.ends[b].0.is_some();
            let together = !self.parted(&self.given, a, b) && !self.parted(&self.given, b, a);
            let meet = self.instance.tables.meet((a, values[a]), (b, values[b]));
            let still = |site: usize| self.ends[site] == (None, None);
            if placed && self.objects[a] != self.objects[b] && together && meet && !still(a) && !still(b) {
                collisions.push((a, b));
            }
        }
        self.orient(values, &collisions, &mut Vec::new(), all);
    }

    fn orient(
        &self,
        values: &[usize],
        collisions: &[(usize, usize)],
        orders: &mut Vec<(Event, Event)>,
        all: &mut BTreeSet<Candidate>,
    ) {
        if self.given.with(orders).is_cyclic() {
            return;
        }
        let Some((&(a, b), rest)) = collisions.split_first() else {
            let needed = |i: &usize| {
                let mut others = orders.clone();
                let (x, y) = others.remove(*i);
                !self.given.with(&others).holds(x, y)
            };
            let mut kept: Vec<(Event, Event)> = (0..orders.len()).filter(needed).map(|i| orders[i]).collect();
            kept.sort_unstable();
            if !self.is_banned(values, &kept) {
                all.insert(Candidate { values: values.to_vec(), orders: kept });
            }
            return;
        };
        for (first, second) in [(a, b), (b, a)] {
            if let (Some(leaves), Some(comes)) = (self.ends[first].1, self.ends[second].0) {
                orders.push((leaves, comes));
                self.orient(values, rest, orders, all);
                orders.pop();
            }
        }
    }

    fn is_banned(&self, values: &[usize], orders: &[(Event, Event)]) -> bool {
        let before = self.given.with(orders);
        let holds = |literal: &Literal| match literal {
            Literal::Pose { occupancy, sample } => {
                let site = self.instance.skeleton.occupancies().position(|site| site == *occupancy).unwrap();
                occupancy.hop == 0 || values[site] == *sample as usize
            }
            Literal::Order { before: x, after: y } => before.holds(*x, *y),
            Literal::Alternative { .. } => false,
        };
        self.instance.nogoods.iter().any(|nogood| nogood.iter().all(holds))
    }
}

#[test]
fn the_enumeration_is_that_of_brute_force_in_the_documented_order() {
    let (mut candidates, mut with_orders, mut most_orders) = (0, 0, 0);
    for seed in 0..5000 {
        let mut instance = Instance::random(seed);
        let found = instance.enumerated(Patience::default());
        let expected = Brute::new(&instance).all();
        let sorted = |list: &[Candidate]| list.iter().cloned().collect::<BTreeSet<Candidate>>();
        assert_eq!(sorted(&found), sorted(&expected), "seed {seed}");
        assert_eq!(found.len(), expected.len(), "seed {seed}: something comes twice");
        assert!(found.is_sorted_by_key(|candidate| candidate.orders.len()), "seed {seed}");
        let sets: BTreeSet<_> = found.iter().map(|candidate| &candidate.orders).collect();
        for set in sets {
            // `expected` is sorted by effort, then values.
            let under_it = |list: &[Candidate]| list.iter().filter(|c| &c.orders == set).cloned().collect::<Vec<_>>();
            assert_eq!(under_it(&found), under_it(&expected), "seed {seed}");
        }
        candidates += found.len();
        with_orders += found.iter().filter(|candidate| !candidate.orders.is_empty()).count();
        most_orders = most_orders.max(found.iter().map(|candidate| candidate.orders.len()).max().unwrap_or(0));
    }
    assert!(candidates > 10_000 && with_orders > 1_500 && most_orders >= 3, "{candidates} {with_orders} {most_orders}");
}

#[test]
fn a_hasty_enumeration_finds_the_same_candidates_in_another_order() {
    let mut disorder = 0;
    for seed in 0..5000 {
        let mut instance = Instance::random(seed);
        let found = instance.enumerated(Patience { work: 1 + seed % 7, tries: 1 + seed % 5, steps: 1 + seed % 3 });
        let expected = Brute::new(&instance).all();
        let set: BTreeSet<&Candidate> = found.iter().collect();
        assert_eq!(set, expected.iter().collect(), "seed {seed}");
        assert_eq!(found.len(), expected.len(), "seed {seed}: something comes twice");
        disorder += usize::from(found != instance.enumerated(Patience::default()));
    }
    assert!(disorder > 60, "{disorder}");
}

/// Two robots bring one object each to a region of its own; in each region only one sample is free of the other's.
#[test]
fn a_combination_off_the_diagonal_of_two_regions_is_found() {
    let problem = problem(&[(0, 0), (1, 1)], 2, 3);
    let skeleton = Skeleton::of_problem(&problem).unwrap();
    let sizes: Vec<usize> = skeleton.occupancies().map(|site| if site.hop == 0 { 1 } else { 5 }).collect();
    // Sites: m0 start, m0 hop 1, m1 start, m1 hop 1, m2 (an obstacle that the listed collisions stand for).
    let mut tables = Tables::random(&sizes, |_| false, &mut Random(0));
    for (va, vb) in (0..5).flat_map(|va| (0..5).map(move |vb| (va, vb))) {
        if (va, vb) != (1, 3) {
            tables.collide((1, va), (3, vb));
        }
    }
    let mut instance = Instance { problem, skeleton, sizes, tables, nogoods: vec![] };
    let found = instance.enumerated(Patience::default());
    assert_eq!(found.len(), 1, "neither object leaves again: no order can part them");
    assert_eq!((found[0].values[1], found[0].values[3]), (1, 3));
}
