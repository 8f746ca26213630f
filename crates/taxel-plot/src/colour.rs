//! Colour maps: a position between 0 and 1 becomes a colour.

mod tables;

/// Red, green, blue, 0 to 255 each.
pub type Rgb = [u8; 3];

/// A perceptually uniform colour map of 256 colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub enum ColourMap {
    /// Black, purple, orange, pale yellow.
    #[default]
    Inferno,
    /// Purple, green, yellow.
    Viridis,
    /// Black, purple, pink, white.
    Magma,
    /// Blue, grey, yellow; for every kind of colour vision.
    Cividis,
}

impl ColourMap {
    /// Every map, the default first.
    pub const ALL: [ColourMap; 4] = [
        ColourMap::Inferno,
        ColourMap::Viridis,
        ColourMap::Magma,
        ColourMap::Cividis,
    ];

    /// Its name, as in matplotlib.
    pub fn name(self) -> &'static str {
        match self {
            ColourMap::Inferno => "inferno",
            ColourMap::Viridis => "viridis",
            ColourMap::Magma => "magma",
            ColourMap::Cividis => "cividis",
        }
    }

    /// The map of that name.
    pub fn from_name(name: &str) -> Option<ColourMap> {
        Self::ALL.into_iter().find(|map| map.name() == name)
    }

    /// The colour at `position`: 0 is the dark end, 1 the bright end; beyond them the ends, NaN the dark end.
    pub fn rgb(self, position: f64) -> Rgb {
        self.entry(index_of(position))
    }

    /// The colour at `index` of the table.
    pub(crate) fn entry(self, index: u8) -> Rgb {
        let [_, red, green, blue] = self.table()[usize::from(index)].to_be_bytes();
        [red, green, blue]
    }

    fn table(self) -> &'static [u32; 256] {
        match self {
            ColourMap::Inferno => &tables::INFERNO,
            ColourMap::Viridis => &tables::VIRIDIS,
            ColourMap::Magma => &tables::MAGMA,
            ColourMap::Cividis => &tables::CIVIDIS,
        }
    }
}

/// Which of 256 equal intervals of 0..1 holds `position`.
pub(crate) fn index_of(position: f64) -> u8 {
    // `as` saturates: negative numbers and NaN give 0, large ones 255.
    (position * 256.0) as u8
}

/// `#rrggbb`.
pub(crate) fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_those_published() {
        assert_eq!(ColourMap::Inferno.rgb(0.0), [0, 0, 4]);
        assert_eq!(ColourMap::Inferno.rgb(1.0), [252, 255, 164]);
        assert_eq!(ColourMap::Viridis.rgb(0.0), [68, 1, 84]);
        assert_eq!(ColourMap::Viridis.rgb(1.0), [253, 231, 37]);
        assert_eq!(ColourMap::Magma.rgb(1.0), [252, 253, 191]);
        assert_eq!(ColourMap::Cividis.rgb(0.0), [0, 34, 78]);
    }

    #[test]
    fn positions_beyond_the_ends_give_the_ends() {
        for map in ColourMap::ALL {
            assert_eq!(map.rgb(-3.0), map.rgb(0.0));
            assert_eq!(map.rgb(f64::INFINITY), map.rgb(1.0));
            assert_eq!(map.rgb(f64::NAN), map.rgb(0.0));
        }
    }

    #[test]
    fn brightness_grows_along_every_map() {
        let luma =
            |[r, g, b]: Rgb| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        for map in ColourMap::ALL {
            for i in 0..16_u8 {
                assert!(
                    luma(map.entry(i * 15 + 15)) > luma(map.entry(i * 15)),
                    "{}",
                    map.name()
                );
            }
        }
    }

    #[test]
    fn names_round_trip() {
        for map in ColourMap::ALL {
            assert_eq!(ColourMap::from_name(map.name()), Some(map));
        }
        assert_eq!(ColourMap::from_name("jet"), None);
    }
}
