use crate::*;

fn kinds() -> Vec<KindInfo> {
    let kind = |name: &str, overflow| KindInfo {
        name: name.into(),
        version: 1,
        overflow,
    };
    vec![
        kind("state", Overflow::DropOldest),
        kind("event", Overflow::Refuse),
        kind("block", Overflow::DropOldest),
    ]
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| n.to_string()).collect()
}

fn message(kind: &str, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    push_frame(&mut bytes, kind_id(kind), 1, payload);
    bytes
}

fn router(limits: Limits) -> (Router, EndpointId, EndpointId) {
    let mut router = Router::new(limits, kinds()).unwrap();
    let all = names(&["state", "event", "block"]);
    let talker = router.register("talker", &all, &names(&["event"])).unwrap();
    let listener = router.register("listener", &[], &all).unwrap();
    (router, talker, listener)
}

fn payloads(bytes: &[u8]) -> Vec<Vec<u8>> {
    Frames::new(bytes)
        .map(|f| f.unwrap().payload.to_vec())
        .collect()
}

#[test]
fn order_is_that_of_publication_and_nobody_hears_himself() {
    let (mut router, talker, listener) = router(Limits::default());
    let both = [message("event", b"1"), message("state", b"2")].concat();
    router.publish(talker, 5, &both).unwrap();
    router.publish(HOST, 6, &message("event", b"3")).unwrap();
    assert_eq!(
        payloads(&router.take_messages(listener)),
        [b"1", b"2", b"3"]
    );
    assert_eq!(payloads(&router.take_messages(talker)), [b"3"]);
    assert!(router.take_messages(listener).is_empty());
    let log = router.take_log();
    let stamps: Vec<_> = Frames::new(&log)
        .map(|f| f.unwrap().header)
        .map(|h| (h.sender, h.time_ns))
        .collect();
    assert_eq!(stamps, [(talker, 5), (talker, 5), (HOST, 6)]);
}

#[test]
fn topics_are_checked_against_the_manifest() {
    let (mut router, _, listener) = router(Limits::default());
    assert_eq!(
        router.publish(listener, 0, &message("event", b"")),
        Err(Violation::NotDeclared("event".into()))
    );
    assert_eq!(
        router.publish(listener, 0, &message("no such kind", b"")),
        Err(Violation::UnknownKind(kind_id("no such kind")))
    );
    let error = router
        .register("third", &names(&["nothing"]), &[])
        .unwrap_err();
    assert!(matches!(error, RouterError::UnknownKind { .. }));
    let error = router.register("talker", &[], &[]).unwrap_err();
    assert_eq!(error, RouterError::DuplicateEndpoint("talker".into()));
    let twice = [kinds(), kinds()].concat();
    assert!(matches!(
        Router::new(Limits::default(), twice),
        Err(RouterError::DuplicateKind(..))
    ));
}

#[test]
fn another_version_is_refused() {
    let (mut router, talker, _) = router(Limits::default());
    let mut bytes = Vec::new();
    push_frame(&mut bytes, kind_id("event"), 2, b"");
    assert!(matches!(
        router.publish(talker, 0, &bytes),
        Err(Violation::Version { found: 2, .. })
    ));
}

#[test]
fn a_full_queue_drops_the_oldest_state_and_refuses_events() {
    let (mut router, talker, listener) = router(Limits {
        messages: 3,
        bytes: 1 << 20,
    });
    router.publish(talker, 0, &message("event", b"e")).unwrap();
    for i in 0..5_u8 {
        router.publish(talker, 0, &message("state", &[i])).unwrap();
    }
    // Capacity 3: the event and the two newest states are left, three states are lost.
    assert_eq!(
        router.take_dropped(),
        [("listener".into(), "state".into(), 3)]
    );
    let full = router.clone().publish(talker, 0, &message("event", b"x"));
    assert_eq!(
        full,
        Err(Violation::Overflow {
            kind: "event".into(),
            subscriber: "listener".into()
        })
    );
    assert_eq!(
        payloads(&router.take_messages(listener)),
        [vec![b'e'], vec![3], vec![4]]
    );
}

#[test]
fn the_latest_block_of_each_name_is_what_a_reader_gets() {
    let (mut router, talker, listener) = router(Limits::default());
    let block = |name: &str, value| {
        BlockBuilder::new("block", name, 0, 0)
            .f64s("x", [value])
            .finish()
    };
    for words in [block("a", 1.0), block("b", 2.0), block("a", 3.0)] {
        router
            .publish_block(talker, kind_id("block"), &words)
            .unwrap();
    }
    let mut values: Vec<_> = router
        .blocks_for(listener)
        .iter()
        .map(|b| (b.view().name(), b.view().f64s("x").unwrap()[0]))
        .collect();
    values.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert_eq!(values, [(kind_id("b"), 2.0), (kind_id("a"), 3.0)]);
    assert_eq!(router.blocks_for(talker), []);
    assert_eq!(router.take_new_blocks().len(), 3);
    let wrong = router.publish_block(talker, kind_id("block"), &[1, 2, 3]);
    assert!(matches!(wrong, Err(Violation::Block(_))));
}

#[test]
fn a_saved_bus_goes_on_where_it_was() {
    let (mut first, talker, listener) = router(Limits::default());
    first
        .publish(talker, 9, &message("event", b"in flight"))
        .unwrap();
    let words = BlockBuilder::new("block", "a", 1, 9)
        .f64s("x", [4.0])
        .finish();
    first
        .publish_block(talker, kind_id("block"), &words)
        .unwrap();
    let state = first.save();
    let (mut second, ..) = router(Limits::default());
    second.restore(&state).unwrap();
    assert_eq!(second.save(), state);
    assert_eq!(
        second.take_messages(listener),
        first.take_messages(listener)
    );
    assert_eq!(second.blocks_for(listener), first.blocks_for(listener));
    for cut in 1..state.len() {
        let _ = second.restore(&state[..cut]);
    }
}
