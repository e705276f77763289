//! A worker process.

use bus::{Role, Worker};
use contract::{ProblemStatement, Stage, StageKind, serve};

use super::member::{MemberArgs, MemberFault, Membership};

/// Makes the stage of a statement, or says why it cannot.
pub type MakeStage<'a> = dyn Fn(&ProblemStatement) -> Result<Box<dyn Stage>, String> + 'a;

/// Serves one stage of a run until the run is over. `make` makes the stage when the statement has come.
///
/// # Errors
/// [`MemberFault`].
pub fn run(args: &MemberArgs, kind: StageKind, implementation: &str, make: &MakeStage) -> Result<(), MemberFault> {
    let membership = Membership::begin(args)?;
    let role = Role::Worker(kind);
    let hello = membership.hello(role, implementation);
    let connection = membership.join(role)?;
    let mut worker = Worker::join(connection, membership.run(), membership.id(), kind, hello, membership.stop.clone())?;
    let Some(statement) = worker.statement()? else { return Ok(()) };
    let stage = make(&statement).map_err(MemberFault::Stage)?;
    serve(stage.as_ref(), &mut worker)?;
    // The run is over: the supervisor removes what it has left, all at once.
    std::mem::forget(worker);
    Ok(())
}
