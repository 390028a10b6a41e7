//! The boundary in this process: the calls that a run never makes, and what the SDK's test host finds.

use microsim_sdk::export::create;
use microsim_sdk::message::{InputEnd, LevelEvent, LocalText, decode_bytes, encode};
use microsim_sdk::{Fault, Plugin, Services, Setup, TestHost, Tick};

fn setup() -> Setup {
    Setup {
        name: "tested".into(),
        seed: 1,
        tick_ns: 8_000_000,
        steps: 1,
        level: 1,
        config: serde_json::Value::Null,
        files: Vec::new(),
    }
}

/// Panics, or answers with a fault, wherever it can; `PANICS` selects which.
struct Bad<const PANICS: bool>;

impl<const PANICS: bool> Bad<PANICS> {
    fn go_wrong<T>(place: &str) -> Result<T, Fault> {
        if PANICS {
            panic!("bad in {place}");
        }
        Err(Fault::new(format!("bad in {place}")))
    }
}

impl<const PANICS: bool> Plugin for Bad<PANICS> {
    fn new() -> Self {
        Self
    }

    fn initialise(&mut self, _: &Setup, _: Services) -> Result<(), Fault> {
        Self::go_wrong("initialise")
    }

    fn reset(&mut self) -> Result<(), Fault> {
        Self::go_wrong("reset")
    }

    fn process(&mut self, _: &mut Tick<'_>) -> Result<(), Fault> {
        Self::go_wrong("process")
    }

    fn save(&self) -> Vec<u8> {
        Self::go_wrong("save").unwrap_or_default()
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Self::go_wrong("restore")
    }

    fn stop(&mut self) -> Result<(), Fault> {
        Self::go_wrong("stop")
    }

    fn extension(&mut self, _: &str, _: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        Self::go_wrong("extension")
    }
}

impl<const PANICS: bool> Drop for Bad<PANICS> {
    fn drop(&mut self) {
        let _: Result<(), Fault> = Self::go_wrong("drop");
    }
}

/// What a call over the boundary answers: kind and text of its fault.
macro_rules! answer {
    ($plugin:ty, $call:ident($($argument:expr),*)) => {{
        let mut object = create::<$plugin>().into_result().expect("`new` is fine");
        let fault = object.$call($($argument),*).into_result().map(drop).expect_err("a fault");
        // After a panic nothing of the plugin is called any more.
        let again = object.$call($($argument),*).into_result().map(drop).expect_err("a fault");
        (format!("{:?}", fault.kind), fault.text.into_string(), again.text.into_string())
    }};
}

#[test]
fn every_call_catches_a_panic() {
    let nothing = [];
    let call = || (&nothing[..]).into();
    let answers = [
        ("reset", answer!(Bad<true>, reset())),
        ("save", answer!(Bad<true>, save())),
        ("restore", answer!(Bad<true>, restore(call()))),
        ("stop", answer!(Bad<true>, stop())),
        (
            "extension",
            answer!(Bad<true>, extension("later".into(), call())),
        ),
    ];
    for (place, (kind, text, again)) in answers {
        assert_eq!(kind, "Panic", "{place}: {text}");
        assert!(
            text.contains("boundary.rs:") && text.ends_with(&format!("bad in {place}")),
            "{text}"
        );
        assert_eq!(again, "called again after a panic");
    }
}

#[test]
fn every_call_hands_a_fault_over() {
    let nothing = [];
    let call = || (&nothing[..]).into();
    let answers = [
        ("reset", answer!(Bad<false>, reset())),
        ("restore", answer!(Bad<false>, restore(call()))),
        ("stop", answer!(Bad<false>, stop())),
        (
            "extension",
            answer!(Bad<false>, extension("later".into(), call())),
        ),
    ];
    for (place, (kind, text, again)) in answers {
        let text_expected = format!("bad in {place}");
        assert_eq!(
            (kind.as_str(), &text, &again),
            ("Error", &text_expected, &text_expected)
        );
    }
}

#[test]
fn a_set_up_that_is_none() {
    let mut object = create::<Bad<true>>().into_result().expect("`new` is fine");
    let garbage = [0xc1_u8, 0xff, 0x00];
    let answer = object
        .initialise((&garbage[..]).into(), None.into())
        .into_result();
    // 0xc1 is the one byte that MessagePack never uses.
    let fault = answer.expect_err("a fault");
    assert_eq!(format!("{:?}", fault.kind), "Error", "{}", fault.text);
}

#[test]
fn the_test_host_hands_faults_over() {
    let new = TestHost::<Bad<true>>::new(&[], &[], &[], setup());
    let fault = new.err().expect("`initialise` panics");
    assert!(fault.text.ends_with("bad in initialise"), "{fault}");
    let new = TestHost::<Bad<false>>::new(&[], &[], &[], setup());
    assert_eq!(new.err(), Some(Fault::new("bad in initialise")));
}

/// Publishes how many ticks it has seen; saves that only if `SAVES`.
struct Counting<const SAVES: bool>(u64);

impl<const SAVES: bool> Plugin for Counting<SAVES> {
    fn new() -> Self {
        Self(0)
    }

    fn initialise(&mut self, _: &Setup, _: Services) -> Result<(), Fault> {
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.0 = 0;
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        self.0 += 1;
        let text = LocalText::new(String::new(), self.0.to_string());
        tick.publish(&LevelEvent {
            id: "count".into(),
            time: tick.time(),
            text,
        });
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&if SAVES { self.0 } else { 0 })
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        self.0 = decode_bytes(state)?;
        Ok(())
    }
}

fn counted<P: Plugin>(mut host: TestHost<P>) -> Vec<String> {
    let ticks = (0..3).map(|_| {
        host.tick()
            .expect("a tick")
            .last::<LevelEvent>()
            .expect("an event")
            .text
            .en
            .into_owned()
    });
    ticks.collect()
}

#[test]
fn the_test_host_finds_state_that_is_not_saved() {
    let host =
        TestHost::<Counting<true>>::new(&["level.event"], &[], &[], setup()).expect("starts");
    assert_eq!(counted(host.moving()), ["1", "2", "3"]);
    let host =
        TestHost::<Counting<false>>::new(&["level.event"], &[], &[], setup()).expect("starts");
    assert_eq!(counted(host), ["1", "2", "3"]);
    let host =
        TestHost::<Counting<false>>::new(&["level.event"], &[], &[], setup()).expect("starts");
    assert_eq!(counted(host.moving()), ["1", "1", "1"]);
}

#[test]
fn the_test_host_finds_topics_that_are_not_declared() {
    let mut host =
        TestHost::<Counting<true>>::new(&[], &["input.end"], &[], setup()).expect("starts");
    host.send(&InputEnd {
        source: "test".into(),
    });
    let fault = host.tick().expect_err("not declared");
    let expected = "published \"level.event\", which its manifest does not list under `publishes`";
    assert_eq!(fault, Fault::new(expected));
    let unknown = TestHost::<Counting<true>>::new(&["nobody.knows"], &[], &[], setup());
    let expected =
        "\"tested\" names the message kind \"nobody.knows\", which no loaded plugin brings";
    assert_eq!(unknown.err(), Some(Fault::new(expected)));
}
