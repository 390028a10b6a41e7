//! What the colours of surfaces mean: a scale with its ends, or classes with their names.

use microsim_vocabulary::{DebugView, Remedy};

use crate::caption::SIDE;
use crate::colour_map::colour_of;
use crate::image::Image;

/// Steps of the scale that is drawn.
const STEPS: u32 = 64;
/// Around and between what is drawn \[dots\].
const MARGIN: u32 = 4;
/// Height of the scale \[dots\].
const BAR: u32 = 10;
/// Length of the scale \[dots\].
const LENGTH: u32 = 200;

/// Of tissue about which nothing had to be done.
pub const NO_REMEDY: [f32; 3] = [0.75, 0.75, 0.75];

/// The colour of what had to be done, sRGB: by Okabe and Ito, for all kinds of colour vision.
pub fn of_remedy(remedy: Remedy) -> [f32; 3] {
    let colour: [u8; 3] = match remedy {
        Remedy::Inertia => [86, 180, 233],
        Remedy::Inverted => [213, 94, 0],
        Remedy::Overlap => [240, 228, 66],
        Remedy::Repeated => [0, 114, 178],
        Remedy::Stiffened => [0, 158, 115],
        Remedy::Held => [204, 121, 167],
    };
    colour.map(|part| f32::from(part) / 255.0)
}

/// From the one that is shown before all others.
const BY_WEIGHT: [Remedy; 6] = [
    Remedy::Inverted,
    Remedy::Held,
    Remedy::Repeated,
    Remedy::Overlap,
    Remedy::Inertia,
    Remedy::Stiffened,
];

/// What the colours of the surfaces of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Legend {
    /// Von Mises stress from 0 on.
    Stress {
        /// The end of the scale \[Pa\]: one, two or five of a power of ten; 0 where there are no values.
        top: f64,
        /// Whether there are values above it, which have the colour of the end.
        is_exceeded: bool,
    },
    /// Quality of elements, from 0, flat or inside out, to 1, regular.
    Quality,
    /// What had to be done.
    Remedies,
}

/// The words of a legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LegendWords<'a> {
    /// Of stress.
    pub stress: &'a str,
    /// Where no body has any, at rest or as it is of springs.
    pub no_stress: &'a str,
    /// Of quality.
    pub quality: &'a str,
    /// Of what had to be done.
    pub remedies: &'a str,
    /// Each of [`Remedy::ALL`].
    pub each: [&'a str; 6],
    /// Nothing had to be done.
    pub none: &'a str,
    /// Between the whole and the rest of a number.
    pub decimal: char,
}

impl LegendWords<'static> {
    /// English, as in pictures that are written to files.
    pub const ENGLISH: Self = Self {
        stress: "von Mises stress",
        no_stress: "no stress in any body",
        quality: "worst element at a node",
        remedies: "what the computation needed",
        each: [
            "inertia added",
            "element inside out",
            "overlap undone",
            "computed again",
            "stiffened: shorter steps",
            "held: no step succeeded",
        ],
        none: "nothing",
        decimal: '.',
    };
}

impl Legend {
    /// A scale of these stresses \[Pa\], of which at most this part may lie above its end.
    pub(crate) fn of_stress(mut values: Vec<f64>, above: f64) -> Self {
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        let place = ((1.0 - above) * values.len() as f64).ceil() as usize;
        let largest = values.last().copied().unwrap_or_default();
        let found = values.get(place.saturating_sub(1)).copied();
        // Where the most of it bears nothing, the rest counts.
        let found = found.filter(|found| *found > 0.0).unwrap_or(largest);
        let top = round_number(found);
        Self::Stress {
            top,
            is_exceeded: largest > top,
        }
    }

    /// Where on the scale a value is, from 0 to 1.
    pub fn part(&self, value: f64) -> f64 {
        let part = match self {
            Self::Stress { top, .. } if *top > 0.0 => value / top,
            Self::Stress { .. } | Self::Remedies => 0.0,
            Self::Quality => value,
        };
        // Where forces overflow there is no smaller one.
        match part.is_nan() {
            true => 1.0,
            false => part.clamp(0.0, 1.0),
        }
    }

    /// What is shown of several remedies by their bits; `None` of none.
    pub fn worst(bits: u32) -> Option<Remedy> {
        let mut all = BY_WEIGHT.into_iter();
        all.find(|remedy| bits & remedy.bit() != 0)
    }

    /// Which view it is of.
    pub fn view(&self) -> DebugView {
        match self {
            Self::Stress { .. } => DebugView::Stress,
            Self::Quality => DebugView::Quality,
            Self::Remedies => DebugView::Remedies,
        }
    }

    /// What stands above it.
    pub fn title<'a>(&self, words: &LegendWords<'a>) -> &'a str {
        match self {
            Self::Stress { top: 0.0, .. } => words.no_stress,
            Self::Stress { .. } => words.stress,
            Self::Quality => words.quality,
            Self::Remedies => words.remedies,
        }
    }

    /// The numbers at the beginning, the middle and the end of the scale; `None` without one.
    pub fn numbers(&self, words: &LegendWords<'_>) -> Option<[String; 3]> {
        let decimal = |text: String| text.replace('.', &words.decimal.to_string());
        match self {
            Self::Stress { top: 0.0, .. } | Self::Remedies => None,
            Self::Stress { top, is_exceeded } => {
                let end = pascals(*top);
                let end = match is_exceeded {
                    true => format!(">{end}"),
                    false => end,
                };
                Some(["0".into(), pascals(0.5 * top), end].map(decimal))
            }
            Self::Quality => Some(["0", "0.5", "1"].map(|text| decimal(text.into()))),
        }
    }

    /// The classes with their colours; none where there is a scale.
    pub fn classes<'a>(&self, words: &LegendWords<'a>) -> Vec<([f32; 3], &'a str)> {
        match self {
            Self::Remedies => {
                let each = Remedy::ALL.map(of_remedy).into_iter().zip(words.each);
                each.chain([(NO_REMEDY, words.none)]).collect()
            }
            Self::Stress { .. } | Self::Quality => Vec::new(),
        }
    }
}

/// The smallest of one, two and five times a power of ten that is not less; 0 of what is not above 0.
fn round_number(value: f64) -> f64 {
    if value.is_nan() || value <= 0.0 || value.is_infinite() {
        return 0.0;
    }
    let power = |exponent: f64| libm::pow(10.0, exponent);
    let exponent = libm::log10(value).floor();
    let candidates = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power(exponent));
    let found = candidates.into_iter().find(|found| *found >= value);
    found.unwrap_or(10.0 * power(exponent))
}

/// A stress with its unit.
fn pascals(value: f64) -> String {
    let (scaled, unit) = match value {
        _ if value >= 1e6 => (1e-6 * value, "MPa"),
        _ if value >= 1e3 => (1e-3 * value, "kPa"),
        _ => (value, "Pa"),
    };
    // Two places are enough for half of one, two or five; those that are zero are not written.
    let digits = format!("{scaled:.3}");
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{digits} {unit}")
}

impl Image {
    /// Draws a legend in the upper left corner, on what is dimmed behind it.
    pub fn write_legend(&mut self, legend: &Legend, words: &LegendWords<'_>) {
        let dot = self.dot();
        let (title, classes) = (legend.title(words), legend.classes(words));
        let numbers = legend.numbers(words);
        let row = SIDE + MARGIN;
        let longest = classes.iter().map(|(_, name)| name.chars().count() as u32);
        let longest = longest.max().map_or(0, |longest| longest * SIDE + row);
        let width = LENGTH.max(title.chars().count() as u32 * SIDE).max(longest);
        let rows = row + classes.len() as u32 * row;
        let height = MARGIN + rows + numbers.as_ref().map_or(0, |_| BAR + MARGIN + row);
        self.dim([0, 0], [(width + 2 * MARGIN) * dot, height * dot]);
        self.write_line([MARGIN, MARGIN], title);
        if let Some(numbers) = numbers {
            let top = MARGIN + row;
            for step in 0..STEPS {
                let [from, to] = [step, step + 1].map(|k| MARGIN * dot + k * LENGTH * dot / STEPS);
                let colour = colour_of((f64::from(step) + 0.5) / f64::from(STEPS));
                self.fill([from, top * dot], [to - from, BAR * dot], colour);
            }
            let below = top + BAR + MARGIN;
            for (part, number) in numbers.iter().enumerate() {
                let long = number.chars().count() as u32 * SIDE;
                // At its left end, around its middle, at its right end.
                let left = MARGIN + (LENGTH.saturating_sub(long)) * part as u32 / 2;
                self.write_line([left, below], number);
            }
        }
        for (number, (colour, name)) in classes.iter().enumerate() {
            let top = MARGIN + row * (1 + number as u32);
            let side = SIDE * dot;
            self.fill([MARGIN * dot, top * dot], [side, side], *colour);
            self.write_line([MARGIN + row, top], name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: LegendWords<'static> = LegendWords::ENGLISH;

    fn scale(values: &[f64]) -> Legend {
        Legend::of_stress(values.to_vec(), 0.02)
    }

    #[test]
    fn a_scale_ends_at_a_round_number() {
        let ends = |values: &[f64]| scale(values).numbers(&WORDS);
        let texts =
            |low: &str, middle: &str, high: &str| Some([low, middle, high].map(String::from));
        assert_eq!(ends(&[10.0, 1234.0]), texts("0", "1 kPa", "2 kPa"));
        assert_eq!(ends(&[4.1e6]), texts("0", "2.5 MPa", "5 MPa"));
        assert_eq!(ends(&[0.3]), texts("0", "0.25 Pa", "0.5 Pa"));
        assert_eq!(ends(&[1000.0]), texts("0", "500 Pa", "1 kPa"));
        // Of a hundred values two may lie above it.
        let mut many = vec![90.0; 98];
        many.extend([5e4; 2]);
        assert_eq!(ends(&many), texts("0", "50 Pa", ">100 Pa"));
        assert_eq!(scale(&many).part(5e4), 1.0);
        let german = LegendWords {
            decimal: ',',
            ..WORDS
        };
        let numbers = scale(&[4.1e6]).numbers(&german).expect("a scale");
        assert_eq!(numbers[1], "2,5 MPa");
        assert_eq!(Legend::Quality.numbers(&WORDS), texts("0", "0.5", "1"));
    }

    /// Where no body has a stress the legend states that, and has no scale.
    /// Stress that overflows does not make the scale, and has its last colour.
    #[test]
    fn what_is_no_number_is_at_the_end() {
        let legend = scale(&[f64::NAN, 1.0, 2.0, f64::INFINITY]);
        assert_eq!(legend, scale(&[1.0, 2.0]));
        assert_eq!(legend.part(f64::NAN), 1.0);
        assert_eq!(legend.part(f64::INFINITY), 1.0);
    }

    #[test]
    fn without_values_there_is_no_scale() {
        let legend = scale(&[]);
        assert_eq!(legend.title(&WORDS), WORDS.no_stress);
        assert_eq!((legend.numbers(&WORDS), legend.part(3.0)), (None, 0.0));
        // At rest it is a stress of nothing, and no scale either.
        assert_eq!(scale(&[0.0; 50]).numbers(&WORDS), None);
        // Most of it bears nothing, and one node does.
        let mut most = vec![0.0; 99];
        most.push(7.0);
        assert_eq!(scale(&most).part(5.0), 0.5);
    }

    /// All classes have names and colours of their own.
    #[test]
    fn every_remedy_has_its_colour_and_its_name() {
        let classes = Legend::Remedies.classes(&WORDS);
        assert_eq!(classes.len(), Remedy::ALL.len() + 1);
        for (index, (colour, name)) in classes.iter().enumerate() {
            let others = classes[index + 1..].iter();
            for (other, its) in others {
                assert!(colour != other && name != its, "{name}");
            }
        }
        assert_eq!(
            classes[1],
            (of_remedy(Remedy::Inverted), "element inside out")
        );
        let bits = Remedy::ALL.map(Remedy::bit).iter().sum();
        assert_eq!(Legend::worst(bits), Some(Remedy::Inverted));
        assert_eq!(Legend::worst(0), None);
        let one = Remedy::ALL.map(|remedy| Legend::worst(remedy.bit()));
        assert_eq!(one, Remedy::ALL.map(Some));
    }

    /// 300 pixels of height are one a dot: the bar begins at 4, is below the line of text (4 + 12) and 200 long, dark at its left and bright at its right end; what
    /// is written differs with the numbers.
    #[test]
    fn the_scale_is_drawn_with_its_numbers() {
        let drawn = |legend: Legend| {
            let mut image = Image::new(300, 300, vec![200; 4 * 300 * 300]);
            image.write_legend(&legend, &WORDS);
            image
        };
        let image = drawn(scale(&[900.0]));
        let bytes = |part: f64| colour_of(part).map(|c| (255.0 * c).round() as u8);
        assert_eq!(image.pixel(4, 20), bytes(0.5 / 64.0));
        assert_eq!(image.pixel(203, 20), bytes(63.5 / 64.0));
        assert_eq!(image.pixel(206, 20), [50; 3], "dimmed");
        assert_eq!(image.pixel(250, 20), [200; 3], "untouched");
        let below = |image: &Image| -> Vec<[u8; 3]> {
            (30..38)
                .flat_map(|y| (4..204).map(move |x| (x, y)))
                .map(|(x, y)| image.pixel(x, y))
                .collect()
        };
        assert!(below(&image).contains(&[255; 3]));
        assert_ne!(below(&image), below(&drawn(scale(&[4000.0]))));
        // Classes: a square each.
        let image = drawn(Legend::Remedies);
        for (number, (colour, _)) in Legend::Remedies.classes(&WORDS).iter().enumerate() {
            let expected = colour.map(|c| (255.0 * c).round() as u8);
            assert_eq!(image.pixel(8, 20 + 12 * number as u32), expected);
        }
    }
}
