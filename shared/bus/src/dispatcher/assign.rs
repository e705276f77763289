//! What is offered next, and what is wanted no more.

use std::collections::BTreeSet;
use std::time::Duration;

use contract::{AskFault, JobId};

use super::Dispatcher;
use crate::{JobOffer, MemberId, Message, Outgoing, Retirement, Topic};

/// Unanswered offers that a worker may have: one in work, one to go on with.
const WINDOW: usize = 2;

impl Dispatcher {
    /// Does what is due: looks ahead, retires, offers, asks the store.
    pub fn tick(&mut self, now: Duration) {
        self.want(now);
        if !self.recovery.complete {
            return;
        }
        if std::mem::take(&mut self.news) {
            self.look_ahead();
        }
        let roster = &self.roster;
        self.flights.keep_alive(|member| roster.is_alive(now, member));
        self.retire();
        self.offer_all(now);
        if let Some(id) = self.asked.iter().find(|id| matches!(self.hopeless.get(id), Some(AskFault::PoisonJob { .. })))
        {
            self.poison = self.jobs.get(id).cloned();
        }
    }

    fn look_ahead(&mut self) {
        self.listed.clear();
        if self.speculation == 0 {
            return;
        }
        let jobs = (self.foresight.jobs)(&|id| self.outcomes.get(id).cloned());
        for job in jobs {
            if self.listed.len() >= self.speculation {
                break;
            }
            let id = self.register(&job);
            if !self.is_settled(&id) && !self.listed.contains(&id) {
                self.listed.push(id);
            }
        }
    }

    fn is_settled(&self, id: &JobId) -> bool {
        self.outcomes.contains_key(id) || self.hopeless.contains_key(id)
    }

    fn retire(&mut self) {
        let live: BTreeSet<JobId> = self.asked.iter().chain(&self.listed).chain(&self.remaking).copied().collect();
        if self.flights.retire(|id| live.contains(id)) {
            let retirement = Retirement { number: self.last_number, live: live.into_iter().collect() };
            self.out.push(Outgoing::plain(Topic::Retirement, Message::Retirement(retirement)));
        }
    }

    fn offer_all(&mut self, now: Duration) {
        let remaking: Vec<JobId> = self.remaking.iter().copied().collect();
        for id in remaking {
            self.offer(now, id, false, true);
        }
        for id in self.asked.clone() {
            if !self.is_settled(&id) {
                self.offer(now, id, false, false);
            }
        }
        for id in self.listed.clone() {
            if !self.is_settled(&id) && !self.asked.contains(&id) {
                self.offer(now, id, true, false);
            }
        }
    }

    fn offer(&mut self, now: Duration, id: JobId, speculative: bool, afresh: bool) {
        if self.lacking.contains_key(&id) {
            return;
        }
        let Some(job) = self.jobs.get(&id) else { return };
        let to = match self.flights.get(&id) {
            // Wanted again, or asked for while it waits behind what was foreseen.
            Some(flight) if flight.retired || (flight.speculative && !speculative && !flight.started) => flight.member,
            Some(_) => return,
            None => {
                let window = if speculative { 1 } else { WINDOW };
                match self.roster.choose(now, job, &self.flights.load(), window) {
                    Some(member) => member,
                    None => return,
                }
            }
        };
        self.send_offer(now, id, to, speculative, afresh);
    }

    fn send_offer(&mut self, now: Duration, id: JobId, to: MemberId, speculative: bool, afresh: bool) {
        let Some(job) = self.jobs.get(&id).cloned() else { return };
        self.last_number += 1;
        self.flights.take_off(now, id, to, speculative);
        let topic = Topic::Offer(job.stage());
        let offer = JobOffer { number: self.last_number, to, speculative, afresh, job };
        self.out.push(Outgoing::about(id, topic, Message::Offer(Box::new(offer))));
    }
}
