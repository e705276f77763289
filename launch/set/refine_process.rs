//! The refiner process.

use std::time::Duration;

use bus::{AskSettings, BusAsk, Connection, Hello, MemberId, Role, RunKey};
use clap::Args;

use super::member::{MemberArgs, MemberFault, Membership};
use super::{Search, Searched};

/// Arguments of the refiner process.
#[derive(Args, Clone, Debug)]
pub struct RefineArgs {
    /// Its place in the run.
    #[command(flatten)]
    pub member: MemberArgs,
    /// Jobs in work that nobody has asked for yet.
    #[arg(long, default_value_t = 2)]
    pub speculation: usize,
    /// Seconds after which the search is ended.
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
}

impl RefineArgs {
    /// The arguments as words.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = self.member.words();
        words.extend(["--speculation".to_owned(), self.speculation.to_string()]);
        words.extend(self.time_limit.iter().flat_map(|limit| ["--time-limit".to_owned(), limit.to_string()]));
        words
    }
}

/// Searches in a run, and tells how it ended until the run is over.
///
/// # Errors
/// [`MemberFault`].
pub fn run(args: &RefineArgs, implementation: &str, search: &Search<'_>) -> Result<(), MemberFault> {
    let membership = Membership::begin(&args.member)?;
    let hello = membership.hello(Role::Refiner, implementation);
    let connection = membership.join(Role::Refiner)?;
    let settings = AskSettings {
        speculation: args.speculation,
        time_limit: args.time_limit.map(|limit| Duration::try_from_secs_f64(limit).unwrap_or(Duration::ZERO)),
        stop: membership.stop.clone(),
    };
    let over = refine(connection, membership.run(), membership.id(), hello, settings, search)?;
    // The run is over: the supervisor removes what it has left, all at once.
    std::mem::forget(over);
    Ok(())
}

/// Searches on a bus, and tells how it ended until the run is over. What it gives back still holds on to the bus.
///
/// # Errors
/// [`MemberFault`].
pub fn refine(
    connection: Connection,
    run: RunKey,
    me: MemberId,
    hello: Hello,
    settings: AskSettings,
    search: &Search<'_>,
) -> Result<Option<BusAsk>, MemberFault> {
    let Some(mut ask) = BusAsk::join(connection, run, me, hello, settings)? else { return Ok(None) };
    let (statement, announcer) = (ask.statement(), ask.announcer());
    let Searched { ledger, conclusion, plan } = search(&statement, &mut ask, &mut |entry| announcer.committed(entry));
    // If even its maker cannot make it again, the end names a plan that nobody has; the supervisor sees that.
    let plan = plan.and_then(|plan| ask.fetch(plan).ok()).map(|bytes| bytes.to_vec());
    ask.conclude(ledger, conclusion, plan);
    Ok(Some(ask))
}
