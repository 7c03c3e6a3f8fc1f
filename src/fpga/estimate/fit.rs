//! The numbers, none of them negative, for which a cost is least.

/// Tries a step up and down for each number in turn, and halves the steps where none of them helps.
pub(super) fn minimise(first: &[f64], cost: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut best = first.to_vec();
    let mut least = cost(&best);
    let mut steps: Vec<f64> = first.iter().map(|value| value.max(0.02)).collect();
    // A step of a millionth changes nothing that is shown; the number of rounds is a guard.
    for _ in 0..20_000 {
        let mut moved = false;
        for index in 0..best.len() {
            for step in [steps[index], -steps[index]] {
                let mut other = best.clone();
                other[index] = (other[index] + step).max(0.0);
                let found = cost(&other);
                if found < least {
                    (best, least, moved) = (other, found, true);
                }
            }
        }
        if !moved {
            steps.iter_mut().for_each(|step| *step /= 2.0);
            if steps.iter().all(|step| *step < 1e-6) {
                break;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_is_found_where_numbers_hang_together_and_none_turns_negative() {
        let found = minimise(&[1.0, 1.0, 1.0], |x| {
            (x[0] + x[1] - 3.0).powi(2) + (x[0] - x[1] - 1.0).powi(2) + (x[2] + 1.0).powi(2)
        });
        assert!(
            (found[0] - 2.0).abs() < 1e-3 && (found[1] - 1.0).abs() < 1e-3 && found[2] == 0.0,
            "{found:?}"
        );
    }
}
