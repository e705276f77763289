//! The only search: decisions, backtracking, nogoods, ledger.
//!
//! Ordinary sequential code. It sees nothing but what [`contract::AskStages::ask`] returns, in program order, so its
//! ledger cannot depend on timing, on the number of workers or on crashes. It names no stage crate and no bus.

mod around;
mod asking;
mod blame;
mod budgets;
mod candidate;
mod chain;
mod commit;
mod compose;
mod conflict;
mod dead_end;
mod generalise;
mod give_way;
mod known;
mod merged;
mod more;
mod orders;
mod passages;
mod reaches;
mod repair;
mod roadmaps;
mod search;
mod synchronous;
mod urgency;
mod ways;

use contract::{AskFault, AskStages, Ledger, LedgerEntry, ProblemStatement, ProductRef};
use plan::{Cause, Certificate, ResultKind, StageCount};
use serde::{Deserialize, Serialize};

/// How a search ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum End {
    /// With a plan.
    Solved {
        /// Product with the bytes of `plan.json`, its ledger digest still empty.
        plan: ProductRef,
        /// Makespan of the task (s).
        makespan_s: f64,
    },
    /// Without one, for a reason that lies in the problem and the samples.
    Failed {
        /// Kind of result.
        result: ResultKind,
        /// Causes with how often each was met, most frequent first.
        causes: Vec<(Cause, u64)>,
        /// A stage's proof, if that is the result; nobody has verified it yet.
        certificate: Option<Certificate>,
    },
    /// Without one, because asking failed.
    Fault(AskFault),
}

/// What a search leaves behind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refinement {
    /// The committed log.
    pub ledger: Ledger,
    /// How it ended.
    pub end: End,
    /// Work of each stage, as far as it was used.
    pub stages: Vec<StageCount>,
}

/// Refines the task plan of a statement. `observe` is told of every committed entry, in order.
pub fn refine_plan(
    statement: &ProblemStatement,
    stages: &mut dyn AskStages,
    observe: &mut dyn FnMut(&LedgerEntry),
) -> Refinement {
    search::Search::new(statement, stages, observe).run()
}
