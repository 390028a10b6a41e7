//! The loop with linked plugins, through the same boundary as loaded ones: order, services, reset, extensions,
//! checkpoints, and what a misbehaving plugin leads to.

use microsim_abi::PluginBox;
use microsim_bus::{BlockBuilder, Frames, Limits, kind_id};
use microsim_host::parallel::Parallel;
use microsim_host::plan::{OwnKind, PlannedPlugin, PluginKind, RunPlan};
use microsim_host::{Engine, Failure, Feed};
use microsim_message::{LocalText, Message, TISSUE_FIELDS, decode, decode_bytes, encode};
use microsim_sdk::{Fault, Plugin, RandomStream, Services, Setup, Tick, export::create};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that is handed on; each plugin that receives it adds its own mark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Count(u64);

impl Message for Count {
    const KIND: &'static str = "counter.count";
}

/// What the last of the chain publishes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Sum(f64);

impl Message for Sum {
    const KIND: &'static str = "counter.sum";
}

/// Publishes 0, 1, 2 … and a random number now and then.
#[derive(Default)]
struct Counter {
    next: u64,
    random: Option<RandomStream>,
}

impl Plugin for Counter {
    fn new() -> Self {
        Self::default()
    }
    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        self.random = Some(RandomStream::new(setup.seed, "counter"));
        Ok(())
    }
    fn reset(&mut self) -> Result<(), Fault> {
        *self = Self {
            next: 0,
            random: Some(RandomStream::new(1, "counter")),
        };
        Ok(())
    }
    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let random = self
            .random
            .as_mut()
            .ok_or_else(|| Fault::new("not initialised"))?;
        self.next += 1 + random.bits() % 7;
        tick.publish(&Count(self.next));
        Ok(())
    }
    fn save(&self) -> Vec<u8> {
        encode(&(self.next, self.random.as_ref().map(RandomStream::save)))
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (next, random): (u64, Option<_>) = decode_bytes(state)?;
        (self.next, self.random) = (next, random.as_ref().map(RandomStream::restore));
        Ok(())
    }
    fn extension(&mut self, name: &str, request: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        Ok((name == "counter.echo").then(|| [request, b"!"].concat()))
    }
}

/// Sums what it receives in fixed parts over the host's threads.
#[derive(Default)]
struct Adder {
    services: Option<Services>,
    sum: f64,
}

impl Plugin for Adder {
    fn new() -> Self {
        Self::default()
    }
    fn initialise(&mut self, _: &Setup, services: Services) -> Result<(), Fault> {
        self.services = Some(services);
        Ok(())
    }
    fn reset(&mut self) -> Result<(), Fault> {
        self.sum = 0.0;
        Ok(())
    }
    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let services = self
            .services
            .as_ref()
            .ok_or_else(|| Fault::new("not initialised"))?;
        for Count(n) in tick.messages::<Count>()? {
            if n > 1_000_000 {
                tick.publish(&Undeclared(0));
            }
            let parts: Vec<AtomicU64> = (0..8).map(|_| AtomicU64::new(0)).collect();
            services.parallel.for_each(parts.len(), &|part| {
                let part_value = 1.0 / (n as f64 + part as f64);
                parts[part].store(part_value.to_bits(), Ordering::Relaxed);
            });
            // The order of the sum is that of the parts, whatever thread computed them.
            self.sum += parts
                .iter()
                .map(|p| f64::from_bits(p.load(Ordering::Relaxed)))
                .sum::<f64>();
        }
        tick.publish(&Sum(self.sum));
        Ok(())
    }
    fn save(&self) -> Vec<u8> {
        encode(&self.sum)
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        self.sum = decode_bytes(state)?;
        Ok(())
    }
    fn extension(&mut self, name: &str, _: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        match (name, self.sum > 0.0) {
            (TISSUE_FIELDS, false) => Err(Fault::new("nothing was added yet")),
            (TISSUE_FIELDS, true) => {
                let block = BlockBuilder::new(TISSUE_FIELDS, "sum", 0, 0);
                Ok(Some(encode(&[block.f64s("sum", [self.sum]).finish()])))
            }
            _ => Ok(None),
        }
    }
}

/// A kind that no manifest lists.
#[derive(Serialize, Deserialize)]
struct Undeclared(u64);

impl Message for Undeclared {
    const KIND: &'static str = "counter.undeclared";
}

fn planned(name: &str, kind: PluginKind, publishes: &[&str], subscribes: &[&str]) -> PlannedPlugin {
    let names = |list: &[&str]| list.iter().map(|s| s.to_string()).collect();
    let own = |name: &str| OwnKind {
        name: name.into(),
        version: 1,
        drop_oldest: false,
    };
    let counter = kind == PluginKind::Source;
    let kinds = [Count::KIND, Sum::KIND, Undeclared::KIND];
    PlannedPlugin {
        name: name.into(),
        kind,
        version: "1.0.0".into(),
        publishes: names(publishes),
        subscribes: names(subscribes),
        own_kinds: if counter {
            kinds.map(own).to_vec()
        } else {
            Vec::new()
        },
        library: Default::default(),
        manifest: String::new(),
        library_hash: String::new(),
        why: String::new(),
        setup: Setup {
            name: name.into(),
            seed: 1,
            tick_ns: 1_000_000,
            steps: 1,
            level: 1,
            config: serde_json::Value::Null,
            files: Vec::new(),
        },
        hosting: Default::default(),
    }
}

fn plan() -> RunPlan {
    RunPlan {
        module: "none".into(),
        module_title: LocalText::default(),
        level: 1,
        variant: None,
        level_title: LocalText::default(),
        level_summary: LocalText::default(),
        seed: 1,
        tick_ns: 1_000_000,
        steps: 1,
        hash_every: 1,
        input: String::new(),
        synthetic: None,
        input_digest: String::new(),
        queue_messages: 4096,
        queue_bytes: 1 << 20,
        model_error: None,
        changed_files: Vec::new(),
        without: Vec::new(),
        plugins: vec![
            planned("counter", PluginKind::Source, &[Count::KIND], &[]),
            planned("adder", PluginKind::Physics, &[Sum::KIND], &[Count::KIND]),
        ],
        parts: Vec::new(),
    }
}

fn object(planned: &PlannedPlugin) -> Result<Option<PluginBox>, Failure> {
    let created = match planned.kind {
        PluginKind::Source => create::<Counter>(),
        _ => create::<Adder>(),
    };
    Ok(Some(created.into_result().map_err(|f| {
        Failure::from_abi(&planned.name, "create", 0, f)
    })?))
}

fn engine(threads: usize) -> Engine {
    let parallel = (threads > 1).then(|| Parallel::new(threads).expect("threads"));
    Engine::new(&plan(), Limits::default(), parallel, object).expect("a good plan")
}

fn run(engine: &mut Engine, ticks: u64) -> [u8; 32] {
    for _ in 0..ticks {
        engine
            .tick(Feed::Live { control: &[] })
            .expect("a good tick");
    }
    engine.chain()
}

#[test]
fn a_message_reaches_the_next_in_line_within_the_tick() {
    let mut engine = engine(1);
    let output = engine
        .tick(Feed::Live { control: &[] })
        .expect("a good tick");
    let frames: Vec<_> = Frames::new(&output.log)
        .map(|f| f.expect("a frame"))
        .collect();
    let kinds: Vec<u64> = frames.iter().map(|f| f.header.kind).collect();
    assert_eq!(kinds, [kind_id(Count::KIND), kind_id(Sum::KIND)]);
    let count = decode::<Count>(&frames[0])
        .expect("a count")
        .expect("readable")
        .0 as f64;
    let sum = decode::<Sum>(&frames[1])
        .expect("a sum")
        .expect("readable")
        .0;
    // Same numbers in the same order as the plugin adds them: equal to the bit.
    assert_eq!(
        sum,
        (0..8)
            .map(|part| 1.0 / (count + f64::from(part)))
            .sum::<f64>()
    );
    assert!(frames.iter().all(|f| f.header.time_ns == 1_000_000));
}

#[test]
fn any_number_of_threads_gives_the_same_hash() {
    let one = run(&mut engine(1), 200);
    for threads in [2, 3, 7] {
        assert_eq!(run(&mut engine(threads), 200), one, "{threads} threads");
    }
}

#[test]
fn reset_is_as_good_as_new() {
    let mut engine = engine(1);
    let first = run(&mut engine, 50);
    run(&mut engine, 13);
    engine.reset().expect("a reset");
    assert_eq!(engine.tick_index(), 0);
    assert_eq!(run(&mut engine, 50), first);
}

#[test]
fn a_checkpoint_goes_on_in_another_engine() {
    let mut whole = engine(1);
    run(&mut whole, 37);
    let checkpoint = whole.checkpoint().expect("a checkpoint");
    let end = run(&mut whole, 63);
    let mut other = engine(2);
    other.restore(&checkpoint).expect("a restore");
    assert_eq!(run(&mut other, 63), end);
    assert_eq!(other.state_digests(&[]), whole.state_digests(&[]));

    let mut foreign = plan();
    foreign.seed = 2;
    let mut foreign = Engine::new(&foreign, Limits::default(), None, object).expect("a good plan");
    let refused = foreign.restore(&checkpoint).expect_err("another seed");
    assert!(
        refused.text.contains("another module, level, seed"),
        "{refused}"
    );
}

#[test]
fn extensions_are_asked_for_by_name() {
    let mut engine = engine(1);
    let answer = engine
        .extension("counter", "counter.echo", b"hello")
        .expect("no fault");
    assert_eq!(answer.as_deref(), Some(&b"hello!"[..]));
    assert_eq!(engine.extension("counter", "draft.unknown", b""), Ok(None));
    assert_eq!(engine.extension("adder", "counter.echo", b""), Ok(None));
    assert_eq!(engine.extension("nobody", "counter.echo", b""), Ok(None));
}

/// What the physics knows of bodies is there when it is asked for, and a run in which it was asked for has the hash of one in which it was not. A plugin that fails in it does not
/// stay away from later ticks unnoticed: the next one fails with its name.
#[test]
fn fields_are_asked_for_and_change_nothing() {
    let (mut asked, mut other) = (engine(1), engine(1));
    run(&mut asked, 3);
    run(&mut other, 3);
    let fields = asked.fields();
    let [fields] = fields.as_slice() else {
        panic!("{fields:?}");
    };
    assert_eq!(fields.view().kind(), kind_id(TISSUE_FIELDS));
    assert!(fields.view().f64s("sum").is_some_and(|sum| sum[0] > 0.0));
    assert_eq!(asked.blocks(), other.blocks());
    assert_eq!(run(&mut asked, 5), run(&mut other, 5));

    let mut failing = engine(1);
    assert!(
        failing.fields().is_empty(),
        "it has none before its first tick"
    );
    let failure = failing
        .tick(Feed::Live { control: &[] })
        .expect_err("it failed");
    assert_eq!(
        (failure.plugin.as_str(), failure.call.as_str()),
        ("adder", "extension")
    );
    assert!(failure.text.contains("nothing was added yet"), "{failure}");
}

#[test]
fn an_undeclared_topic_is_named_with_its_plugin_and_tick() {
    let mut engine = engine(1);
    run(&mut engine, 5);
    let mut state = engine.checkpoint().expect("a checkpoint");
    let random = RandomStream::new(1, "counter").save();
    state.states[0] = encode(&(2_000_000_u64, Some(random))).into();
    engine.restore(&state).expect("a restore");
    let failure = engine.tick(Feed::Live { control: &[] }).expect_err("a lie");
    assert_eq!((failure.plugin.as_str(), failure.tick), ("adder", 5));
    assert!(failure.text.contains("\"counter.undeclared\""), "{failure}");
}

#[test]
fn a_topic_that_nobody_brings_is_refused_before_anything_runs() {
    let mut plan = plan();
    plan.plugins[1].subscribes.push("tissue.magic".into());
    let refused = Engine::new(&plan, Limits::default(), None, object)
        .err()
        .expect("refused");
    assert!(
        refused.to_string().contains("\"tissue.magic\""),
        "{refused}"
    );
}
