//! Which quality a machine draws in time.

use crate::error::RenderError;
use crate::picture::Picture;
use crate::quality::Quality;
use crate::renderer::Renderer;

/// Time for which each quality is measured \[s\]: a second for all three.
const MEASURED: f64 = 0.33;

/// What was measured, and what it comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// Pictures per second of each quality that was drawn, from the least on; one that comes after one that is too slow is not drawn.
    pub rates: Vec<(Quality, f64)>,
    /// The highest that reaches the rate, or the lowest where none does.
    pub quality: Quality,
    /// Whether it reaches the rate.
    pub reached: bool,
}

impl Proposal {
    /// From rates, the least quality first.
    fn of(rates: Vec<(Quality, f64)>, wanted: f64) -> Self {
        let good = rates.iter().rev().find(|(_, rate)| *rate >= wanted);
        Self {
            quality: good.map_or(Quality::Low, |(quality, _)| *quality),
            reached: good.is_some(),
            rates,
        }
    }
}

impl Renderer {
    /// Draws a picture in one quality after the other for a third of a second each and proposes the highest that reaches `wanted` pictures per second; `seconds` is a clock of the caller.
    /// What computes beside should be running. The first picture of a quality, which compiles shaders, does not count. The quality is as before afterwards.
    ///
    /// # Errors
    /// Those of [`render`](Self::render).
    pub fn propose(
        &mut self,
        picture: &Picture,
        wanted: f64,
        seconds: &mut dyn FnMut() -> f64,
    ) -> Result<Proposal, RenderError> {
        let before = self.quality();
        let mut rates = Vec::new();
        for quality in Quality::ALL {
            self.set_quality(quality);
            let rate = self.rate(picture, seconds);
            let rate = match rate {
                Ok(rate) => rate,
                Err(error) => {
                    self.set_quality(before);
                    return Err(error);
                }
            };
            rates.push((quality, rate));
            if rate < wanted {
                break;
            }
        }
        self.set_quality(before);
        Ok(Proposal::of(rates, wanted))
    }

    /// Pictures per second.
    fn rate(
        &mut self,
        picture: &Picture,
        seconds: &mut dyn FnMut() -> f64,
    ) -> Result<f64, RenderError> {
        self.render(picture)?;
        self.finish()?;
        let start = seconds();
        let mut count = 0.0;
        loop {
            self.render(picture)?;
            self.finish()?;
            count += 1.0;
            let passed = seconds() - start;
            if passed >= MEASURED {
                return Ok(count / passed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The highest that is fast enough; where none is, the lowest, and that it is too slow is known.
    #[test]
    fn the_highest_in_time_is_proposed() {
        let rates = vec![
            (Quality::Low, 60.0),
            (Quality::Medium, 31.0),
            (Quality::High, 12.0),
        ];
        let proposal = Proposal::of(rates, 25.0);
        assert_eq!(
            (proposal.quality, proposal.reached),
            (Quality::Medium, true)
        );
        let proposal = Proposal::of(vec![(Quality::Low, 18.0)], 25.0);
        assert_eq!((proposal.quality, proposal.reached), (Quality::Low, false));
    }
}
