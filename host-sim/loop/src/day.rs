//! Days as a profile states them ("2026-11-27"), and as a board stores them, counted from
//! 1970-01-01.

/// Days from 1970-01-01 to a day such as "2026-11-27"; `None` if it is none, or is not within the
/// years that a board can store.
#[must_use]
pub fn day_of(text: &str) -> Option<u16> {
    let mut parts = text.split('-');
    let [year, month, day] = [parts.next()?, parts.next()?, parts.next()?].map(|part| part.parse::<u32>().ok());
    let (year, month, day) = (year?, month?, day?);
    if parts.next().is_some() || !(1970..2149).contains(&year) {
        return None;
    }
    let days = days_to(year, month, day)?;
    u16::try_from(days).ok().filter(|days| *days > 0)
}

/// The day this many days after 1970-01-01, such as "2026-11-27".
#[must_use]
pub fn day_text(days: u16) -> String {
    let days = u32::from(days);
    let year = (1970..2150).rev().find(|year| days_to(*year, 1, 1).is_some_and(|first| first <= days)).unwrap_or(1970);
    let month = (1..=12).rev().find(|month| days_to(year, *month, 1).is_some_and(|first| first <= days)).unwrap_or(1);
    let day = days - days_to(year, month, 1).unwrap_or(days) + 1;
    format!("{year:04}-{month:02}-{day:02}")
}

/// Today, in the same form.
#[must_use]
pub fn today() -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    day_text(u16::try_from(since.as_secs() / 86_400).unwrap_or(u16::MAX))
}

fn days_to(year: u32, month: u32, day: u32) -> Option<u32> {
    let leap = |year: u32| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let lengths = [31, if leap(year) { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let length = *lengths.get(usize::try_from(month.checked_sub(1)?).ok()?)?;
    if !(1..=length).contains(&day) {
        return None;
    }
    let years: u32 = (1970..year).map(|year| if leap(year) { 366 } else { 365 }).sum();
    let months: u32 = lengths.iter().take(month as usize - 1).sum();
    Some(years + months + day - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_told_and_read_back() {
        for (text, days) in [("1970-01-02", 1), ("2000-03-01", 11_017), ("2026-11-27", 20_784)] {
            assert_eq!((day_of(text), day_text(days).as_str()), (Some(days), text));
        }
        for wrong in ["", "2026", "2026-02-29", "2026-13-01", "2026-00-01", "2026-11-27-1", "soon", "1970-01-01"] {
            assert_eq!(day_of(wrong), None, "{wrong}");
        }
    }
}
