//! Cost and benefit of the terms that a scene's tissue and probe have: change of the cost of a tick
//! without each term, and error of omitting it.

use palpate::{Params, Terms};
use palpate_tissue::budget::{CostModel, Counts};

/// Times after which an elastic hold is compared with one that relaxes [s].
const HELD_S: [f32; 2] = [1.0, 10.0];

/// A term of the scene, and the effects of omitting it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(super) struct Worth {
    /// Name of the term.
    pub term: &'static str,
    /// Change of the cost of a tick without the term [%]; negative.
    pub cost_pct: f64,
    /// Error of omitting the term, in words.
    pub error: String,
}

/// The active terms of `params`, with their worth on `machine`.
pub(super) fn of(machine: &CostModel, counts: &Counts, params: &Params) -> Vec<Worth> {
    let cost = |terms: Terms| machine.cost_of(counts, &Params { terms, ..*params }, params.substeps).units;
    let (with, terms) = (cost(params.terms), params.terms);
    let cost_pct = |without: Terms| (cost(without) / with - 1.0) * 100.0;
    let mut found = Vec::new();
    if terms.relaxation && params.relaxation.iter().any(|term| term.share > 0.0) {
        let too_much = HELD_S.map(|held_s| {
            let faded: f32 =
                params.relaxation.iter().filter(|t| t.share > 0.0).map(|t| t.share * -(-held_s / t.time_s).exp_m1()).sum();
            format!("{:+.0} % of force after {held_s} s of holding", (1.0 / (1.0 - faded) - 1.0) * 100.0)
        });
        found.push(Worth {
            term: "relaxation",
            cost_pct: cost_pct(Terms { relaxation: false, ..terms }),
            error: too_much.join(", "),
        });
    }
    if terms.friction && params.friction > 0.0 {
        found.push(Worth {
            term: "friction",
            cost_pct: cost_pct(Terms { friction: false, ..terms }),
            error: format!("no force along the surface, where a slide has {:.2} of the push", params.friction),
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use palpate::PronyTerm;

    use super::*;

    const COUNTS: Counts =
        Counts { nodes: 57, springs: 294, tets: 171, triangles: 60, touched: 17, points: 4, rim_nodes: 0, rim_edges: 0 };

    #[test]
    fn a_plain_scene_has_nothing_to_leave_out() {
        let machine = CostModel::named("m4f-168").unwrap();
        assert_eq!(of(machine, &COUNTS, &Params::default()), []);
    }

    #[test]
    fn each_term_says_what_it_costs_and_what_it_is_worth() {
        let machine = CostModel::named("m4f-168").unwrap();
        let none = PronyTerm::NONE;
        let relaxation = [PronyTerm { share: 0.5, time_s: 1.0 }, none, none];
        let params = Params { relaxation, friction: 0.46, ..Params::default() };
        let found = of(machine, &COUNTS, &params);
        let [relaxes, rubs] = &found[..] else { panic!("{found:?}") };
        // 1 - .5 (1 - 1/e) of the force remains after one second, and half of it after ten
        assert_eq!(relaxes.error, "+46 % of force after 1 s of holding, +100 % of force after 10 s of holding");
        assert!(rubs.error.contains("0.46"), "{rubs:?}");
        for worth in &found {
            assert!((-8.0..-2.0).contains(&worth.cost_pct), "{worth:?}");
        }
    }
}
