//! Bytes on the wire, pinned. A change here is a new contract version.

use bus::{Committed, Envelope, Gone, Heartbeat, Hello, JobOffer, Kept, Kind, MemberId, Message, Retirement, Role};
use bus::{RunKey, Want, checksum};
use contract::{Answer, StageKind};
use contract::{Decision, Digest, Job, JobId, LedgerEntry, Outcome, PlacementJob, ProductRef, Refusal, Request};

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn id(byte: u8) -> JobId {
    JobId(Digest([byte; 32]))
}

#[test]
fn the_envelope_is_eighty_eight_little_endian_bytes_in_order_of_its_fields() {
    let envelope = Envelope {
        contract_version: 1,
        kind: 0x0203,
        run: 0x0405_0607_0809_0a0b,
        job: [0xcc; 32],
        sender: 0x0c0d,
        parts: 3,
        part: 2,
        reserved: 0,
        sequence: 0x11,
        length: 0x1213,
        checksum: 0x1415_1617_1819_1a1b,
    };
    let expected = "01000000 03020000 0b0a090807060504\
        cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc\
        0d0c0000 03000000 02000000 00000000 1100000000000000 1312000000000000 1b1a191817161514";
    assert_eq!(hex(&envelope.to_bytes()), expected.replace(' ', ""));
    assert_eq!(Envelope::from_bytes(&envelope.to_bytes()), envelope);
}

#[test]
fn checksums_and_run_keys_are_the_first_bytes_of_digests() {
    let first = |digest: Digest| u64::from_le_bytes(digest.0[..8].try_into().unwrap());
    assert_eq!(checksum(b"part"), first(Digest::of("mrtamp part", &[b"part"])));
    assert_eq!(RunKey::of_name("a").0, first(Digest::of("mrtamp run", &[b"a"])));
}

#[test]
fn kinds_have_the_numbers_of_their_order() {
    for (kind, number) in Kind::ALL.into_iter().zip(1..) {
        assert_eq!(kind as u32, number);
        assert_eq!(Kind::of_number(number), Some(kind));
    }
    assert_eq!(Kind::of_number(0), None);
    assert_eq!(Kind::of_number(Kind::ALL.len() as u32 + 1), None);
}

fn hello() -> Hello {
    Hello {
        name: "r".to_owned(),
        role: Role::Worker(StageKind::Roadmap),
        robot: Some(model::RobotId(7)),
        implementation: "i/1".to_owned(),
        contract_version: 1,
        statement: None,
    }
}

const HELLO: &str = "0100000000000000 72 02000000 02000000 01 07000000 0300000000000000 692f31 01000000 00";

#[test]
fn bodies_are_fixed_width_little_endian() {
    let job = Job {
        request: Request::Placement(PlacementJob { level: 1, first: 2, count: 3, nogoods: Vec::new() }),
        budget: 4,
    };
    let offer = JobOffer { number: 9, to: MemberId(5), speculative: true, afresh: false, job };
    let outcome = Outcome::answer(Answer::Blocked(vec![true, false]), 6);
    let kept = Kept { batch: 0, batches: 1, outcomes: vec![(id(0xab), outcome.clone())] };
    let ab = "ab".repeat(32);
    let blocked = "00000000 02000000 0200000000000000 01 00 0600000000000000";
    let expected = [
        (
            Message::Offer(Box::new(offer)),
            "0900000000000000 05000000 01 00 00000000 01000000 02000000 03000000 0000000000000000 0400000000000000"
                .to_owned(),
        ),
        (Message::Started, String::new()),
        (Message::Outcome(Box::new(outcome)), blocked.to_owned()),
        (Message::Declined(Refusal::Cancelled), "00000000".to_owned()),
        (
            Message::Declined(Refusal::Lacking(ProductRef { digest: Digest([0xab; 32]), made_by: id(0xab) })),
            format!("01000000 {ab} {ab}"),
        ),
        (Message::Product([1, 2, 3].into()), "010203".to_owned()),
        (Message::Want(Want::Product(Digest([0xab; 32]))), format!("00000000 {ab}")),
        (Message::Want(Want::Outcomes), "01000000".to_owned()),
        (Message::Absent(Digest([0xab; 32])), ab.clone()),
        (Message::Kept(kept), format!("00000000 01000000 0100000000000000 {ab} {blocked}")),
        (
            Message::Retirement(Retirement { number: 3, live: vec![id(0xab)] }),
            format!("0300000000000000 0100000000000000 {ab}"),
        ),
        (
            Message::Committed(Committed { index: 1, entry: LedgerEntry::Decided(Decision::Level(2)) }),
            "0100000000000000 00000000 00000000 02000000".to_owned(),
        ),
        (Message::Hello(hello()), HELLO.to_owned()),
        (
            Message::Heartbeat(Heartbeat { hello: hello(), held: vec![id(0xab)], done: 2 }),
            format!("{HELLO} 0100000000000000 {ab} 0200000000000000"),
        ),
        (Message::Farewell, String::new()),
        (
            Message::Gone(Gone {
                member: MemberId(4),
                stage: Some(StageKind::Composite),
                left: 1,
                died_on: Some((id(0xab), 2)),
            }),
            format!("04000000 01 03000000 01000000 01 {ab} 02000000"),
        ),
        (Message::Shutdown, String::new()),
    ];
    for (message, bytes) in expected {
        let body = message.to_body().unwrap().into_owned();
        assert_eq!(hex(&body), bytes.replace(' ', ""), "{:?}", message.kind());
        assert_eq!(Message::of_body(message.kind(), body).unwrap(), message);
    }
}

#[test]
fn numbers_that_are_none_are_refused_and_infinite_limits_of_a_statement_are_not() {
    let mut statement = crate::toy::toy_statement(0);
    let body = |statement: &contract::ProblemStatement| contract::encode(statement).unwrap();
    statement.problem.settings.lift = f64::INFINITY;
    assert!(Message::of_body(Kind::Statement, body(&statement)).is_ok());
    statement.problem.settings.lift = f64::NAN;
    assert!(Message::of_body(Kind::Statement, body(&statement)).is_err());
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let answer = Answer::Mode {
            roadmap: ProductRef { digest: Digest([0; 32]), made_by: id(1) },
            shortest_s: number,
            in_the_way: Vec::new(),
        };
        let body = contract::encode(&Outcome::answer(answer, 0)).unwrap();
        assert!(Message::of_body(Kind::Sample, body).is_err());
    }
}

#[test]
fn bodies_with_anything_after_them_or_missing_are_refused() {
    let offered = Message::Hello(hello()).to_body().unwrap().into_owned();
    for length in 0..offered.len() {
        assert!(Message::of_body(Kind::Hello, offered[..length].to_vec()).is_err());
    }
    let longer = [offered, vec![0]].concat();
    assert!(Message::of_body(Kind::Hello, longer).is_err());
    assert!(Message::of_body(Kind::Shutdown, vec![0]).is_err());
}

#[test]
fn an_answer_under_the_label_of_a_failure_is_refused() {
    let body = contract::encode(&Outcome::answer(Answer::Blocked(Vec::new()), 0)).unwrap();
    assert!(Message::of_body(Kind::Sample, body.clone()).is_ok());
    assert!(Message::of_body(Kind::FailureReport, body).is_err());
}
