//! Suggestions for misspelt names.

/// A remedy for an unknown name: the nearest known one, or all of them where none is near.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, known.clone()) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => listed(known),
    }
}

/// The known name nearest to `name`, if it is near enough to be meant.
fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    let mut best: Option<(f64, &str)> = None;
    for candidate in known {
        let likeness = strsim::jaro_winkler(&lower, &candidate.to_lowercase());
        if likeness > 0.8 && best.is_none_or(|(most, _)| likeness > most) {
            best = Some((likeness, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

fn listed<'a>(known: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 12;
    let names: Vec<&str> = known.collect();
    if names.is_empty() {
        return "there is none".to_owned();
    }
    let mut text = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text.push_str(&format!(" and {} more", names.len() - MOST));
    }
    format!("there is {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_and_all_names_are_listed_where_none_is_near() {
        let known = ["table_a", "table_b", "shelf"];
        assert_eq!(did_you_mean("shel", known.into_iter()), "did you mean `shelf`?");
        assert_eq!(did_you_mean("TABLE_B", known.into_iter()), "did you mean `table_b`?");
        assert_eq!(did_you_mean("xyzzy", known.into_iter()), "there is `table_a`, `table_b`, `shelf`");
        assert_eq!(did_you_mean("x", [].into_iter()), "there is none");
    }
}
