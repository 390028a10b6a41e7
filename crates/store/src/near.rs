//! Names that are near another.

/// How many are listed.
const MOST: usize = 5;

/// The names that are near `asked`, the nearest first: those that are the same without regard to case, blanks and points, that contain it or are in
/// it, or that differ in at most a third of its letters.
pub(crate) fn near(asked: &str, names: &[String]) -> Vec<String> {
    let asked = folded(asked);
    let most = asked.len() / 3;
    let mut found: Vec<(usize, &String)> = names
        .iter()
        .filter_map(|name| {
            let other = folded(name);
            let contains = |a: &[char], b: &[char]| {
                b.len() >= 3 && a.windows(b.len()).any(|window| window == b)
            };
            if contains(&other, &asked) || contains(&asked, &other) {
                return Some((usize::from(other != asked), name));
            }
            let distance = distance(&asked, &other);
            (distance <= most).then_some((distance, name))
        })
        .collect();
    found.sort();
    found.truncate(MOST);
    found.into_iter().map(|(_, name)| name.clone()).collect()
}

/// The letters and digits of a name in lower case; a long one is cut.
fn folded(name: &str) -> Vec<char> {
    let letters = name.chars().filter(|c| c.is_alphanumeric()).take(200);
    letters.flat_map(char::to_lowercase).collect()
}

/// Fewest insertions, deletions and replacements that make one of the other (Levenshtein).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_and_strangers_are_not() {
        let names = ["A. Muster", "B. Muster", "Élodie Martin", "李 小龍"].map(String::from);
        assert_eq!(near("a muster", &names)[0], "A. Muster");
        // Two letters are in each other's place: a distance of 2, and of 3 from the other name, of 7 letters.
        assert_eq!(near("A. Mustre", &names), ["A. Muster"]);
        assert_eq!(near("Muster", &names), ["A. Muster", "B. Muster"]);
        assert_eq!(near("elodie martin", &names), ["Élodie Martin"]);
        assert_eq!(near("Nobody Else", &names), [""; 0]);
        assert_eq!(near("", &names), [""; 0]);
    }

    #[test]
    fn distances_are_those_of_the_textbook() {
        let chars = |text: &str| text.chars().collect::<Vec<_>>();
        assert_eq!(distance(&chars("kitten"), &chars("sitting")), 3);
        assert_eq!(distance(&chars(""), &chars("abc")), 3);
        assert_eq!(distance(&chars("abc"), &chars("abc")), 0);
    }
}
