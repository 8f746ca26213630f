//! The simplified equations of the paper, for teaching and for the interactive model.
//!
//! Source of all: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", equations 1, 2, 4, 5, 6
//! and 7, with its mistakes corrected where each is described. They look at one row on its own: the pressed
//! taxel R_s, the other pressed taxels of the same row as a leak R_L from the amplifier's input to ground, an
//! amplifier of finite gain A. What they leave out is most of the cross-talk of a real array: the resistance of
//! the row's switch between the row and the amplifier's input, through which the leak really works. The netlist
//! and the forward scan have all of it; see the example of [`v_out_alike`].
//!
//! Resistances in ohms, voltages in volts. An open path is `f64::INFINITY` ohms.

/// The inverting amplifier and the voltage that drives a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplifier {
    /// V_test, volts.
    pub v_test_volts: f64,
    /// R_k, feedback resistor, ohms.
    pub r_feedback_ohms: f64,
    /// A, open-loop gain at the scan rate, a pure number; may be infinite.
    pub open_loop_gain: f64,
}

impl Amplifier {
    /// The paper's Table V: 0.4 V, 2 kΩ, 100 000.
    pub const TABLE_V: Amplifier = Amplifier {
        v_test_volts: 0.4,
        r_feedback_ohms: 2000.0,
        open_loop_gain: 1e5,
    };
}

/// V_out of an ideal amplifier and one pressed taxel, volts: equation 1, right-hand side.
///
/// V_out = −V_test · R_k / R_s
///
/// - V_test, R_k: [`Amplifier`] (V, Ω); its gain is taken as infinite
/// - R_s: `r_taxel_ohms`, the taxel (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 1.
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_ideal};
/// assert_eq!(v_out_ideal(Amplifier::TABLE_V, 1000.0), -0.8);
/// ```
pub fn v_out_ideal(amplifier: Amplifier, r_taxel_ohms: f64) -> f64 {
    -amplifier.v_test_volts * amplifier.r_feedback_ohms / r_taxel_ohms
}

/// V_out of one pressed taxel and an amplifier of finite gain, volts: equation 1.
///
/// V_out = −V_test · R_k / (R_s + R_k/A + R_s/A)
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_s: `r_taxel_ohms`, the taxel (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 1. Exact for this circuit;
/// the paper's A > 100 000 is the gain at zero frequency, that at the scan rate is lower.
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_one_taxel};
/// let slow = Amplifier { open_loop_gain: 100.0, ..Amplifier::TABLE_V };
/// // 3 % lost: 1 kΩ / (1 kΩ + 20 Ω + 10 Ω)
/// assert!((v_out_one_taxel(slow, 1000.0) + 0.8 / 1.03).abs() < 1e-12);
/// ```
pub fn v_out_one_taxel(amplifier: Amplifier, r_taxel_ohms: f64) -> f64 {
    v_out_leak(amplifier, r_taxel_ohms, f64::INFINITY)
}

/// V_out with a leak from the amplifier's input to ground, volts: equation 2.
///
/// V_out = −V_test · R_k / (R_s + R_k/A + R_s/A + R_s·R_k/(A·R_L))
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_s: `r_taxel_ohms`, the taxel (Ω)
/// - R_L: `r_leak_ohms`, all alternative paths in parallel (Ω); see [`r_leak_ohms`]
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 2. Exact for this circuit.
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_leak};
/// let v_out = v_out_leak(Amplifier::TABLE_V, 1000.0, 100.0);
/// assert!((v_out + 800.0 / 1000.23).abs() < 1e-12);
/// ```
pub fn v_out_leak(amplifier: Amplifier, r_taxel_ohms: f64, r_leak_ohms: f64) -> f64 {
    let Amplifier {
        v_test_volts,
        r_feedback_ohms: r_k,
        open_loop_gain: gain,
    } = amplifier;
    let r_s = r_taxel_ohms;
    -v_test_volts * r_k / (r_s + r_k / gain + r_s / gain + r_s * r_k / (gain * r_leak_ohms))
}

/// The same when only the leak matters, volts: equation 2, right-hand side.
///
/// V_out ≈ −V_test · R_k / (R_s · (R_k/(A·R_L) + 1))
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_s: `r_taxel_ohms`, the taxel (Ω)
/// - R_L: `r_leak_ohms`, all alternative paths in parallel (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 2. What is dropped,
/// R_k/A + R_s/A, is of the same size as what is kept unless R_L is much smaller than R_s and R_k.
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_leak_only};
/// let v_out = v_out_leak_only(Amplifier::TABLE_V, 1000.0, 100.0);
/// assert!((v_out + 0.8 / 1.0002).abs() < 1e-12);
/// ```
pub fn v_out_leak_only(amplifier: Amplifier, r_taxel_ohms: f64, r_leak_ohms: f64) -> f64 {
    v_out_ideal(amplifier, r_taxel_ohms)
        / (amplifier.r_feedback_ohms / (amplifier.open_loop_gain * r_leak_ohms) + 1.0)
}

/// R_L of the other pressed taxels of a row, ohms: the unnumbered equation before equation 4.
///
/// R_L = (Σ 1/R_n)⁻¹ over the N other pressed taxels n = 1 … N of the row
///
/// - R_n: `r_others_ohms[n − 1]` (Ω); none: the result is infinite
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", before eq. 4. As printed the sum
/// runs from n = i to i, over a summand without n; it is meant to run over the other pressed taxels.
///
/// ```
/// use taxel::circuit::simplified::r_leak_ohms;
/// assert_eq!(r_leak_ohms(&[1000.0, 1000.0]), 500.0);
/// assert_eq!(r_leak_ohms(&[]), f64::INFINITY);
/// ```
pub fn r_leak_ohms(r_others_ohms: &[f64]) -> f64 {
    1.0 / siemens(r_others_ohms)
}

/// V_out with a switch in series and N other pressed taxels in the row, volts: equation 4.
///
/// V_out ≈ −V_test · R_k / ((R_taxel + R_mux) · ((R_k/A) · Σ 1/R_n + 1)), n = 1 … N
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_taxel: `r_taxel_ohms`, the taxel (Ω)
/// - R_mux: `r_mux_ohms`, on-resistance of the multiplexers (Ω)
/// - R_n: `r_others_ohms[n − 1]`, the other pressed taxels of the row (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 4. The sum has no upper
/// bound as printed; it runs over the N other pressed taxels. R_mux as a whole stands in series with the
/// taxel: right for the column's switch, wrong for the row's, which the leak currents share (10 Ω there and 20
/// other taxels of 1 kΩ take 17 %, and this equation 1 %).
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_switched};
/// let v_out = v_out_switched(Amplifier::TABLE_V, 1000.0, 10.0, &[1000.0; 20]);
/// assert!((v_out + 0.8 / (1.01 * 1.0004)).abs() < 1e-12);
/// ```
pub fn v_out_switched(
    amplifier: Amplifier,
    r_taxel_ohms: f64,
    r_mux_ohms: f64,
    r_others_ohms: &[f64],
) -> f64 {
    let leak = amplifier.r_feedback_ohms / amplifier.open_loop_gain * siemens(r_others_ohms);
    v_out_ideal(amplifier, r_taxel_ohms + r_mux_ohms) / (leak + 1.0)
}

/// V_out with N other pressed taxels in the row, volts: equation 5, equation 4 without switches.
///
/// V_out ≈ −V_test · R_k / (R_taxel · ((R_k/A) · Σ 1/R_n + 1)), n = 1 … N
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_taxel: `r_taxel_ohms`, the taxel (Ω)
/// - R_n: `r_others_ohms[n − 1]`, the other pressed taxels of the row (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 5. The sum has no upper
/// bound as printed; it runs over the N other pressed taxels.
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_row};
/// let v_out = v_out_row(Amplifier::TABLE_V, 1000.0, &[500.0, 2000.0]);
/// assert!((v_out + 0.8 / 1.00005).abs() < 1e-12);
/// ```
pub fn v_out_row(amplifier: Amplifier, r_taxel_ohms: f64, r_others_ohms: &[f64]) -> f64 {
    v_out_switched(amplifier, r_taxel_ohms, 0.0, r_others_ohms)
}

/// V_out with N other taxels of the row pressed alike, volts: equation 6, the paper's interactive model.
///
/// V_out ≈ −V_test · A·R_k·R_i / ((A·R_i + N·R_k) · R_taxel)
///
/// - V_test, R_k, A: [`Amplifier`] (V, Ω, pure number)
/// - R_taxel: `r_taxel_ohms`, the taxel (Ω)
/// - R_i: `r_other_ohms`, each of the others (Ω)
/// - N: `others`, how many other taxels of the row are pressed
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 6. N counts the *other*
/// taxels. The paper sees its measured drop explained by it; with its own numbers (Table V) it predicts 0.04 % at
/// N = 20, a hundredth of what a real row's switch does:
///
/// ```
/// use taxel::circuit::simplified::{Amplifier, v_out_alike};
/// let alone = v_out_alike(Amplifier::TABLE_V, 1000.0, 1000.0, 0);
/// let with_20 = v_out_alike(Amplifier::TABLE_V, 1000.0, 1000.0, 20);
/// assert!((1.0 - with_20 / alone - 0.0004).abs() < 1e-6);
/// ```
pub fn v_out_alike(
    amplifier: Amplifier,
    r_taxel_ohms: f64,
    r_other_ohms: f64,
    others: usize,
) -> f64 {
    v_out_leak_only(amplifier, r_taxel_ohms, r_other_ohms / others as f64)
}

/// What reaches the taxel when a resistor protects the source, volts: equation 7.
///
/// V_in = V_test · R_m / (R_m + R_v)
///
/// - V_test: `v_test_volts` (V)
/// - R_m: `r_path_ohms`, the path from the driven column to ground through other pressed taxels (Ω)
/// - R_v: `r_source_ohms`, the resistor in series with the source (Ω)
///
/// Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", eq. 7. The number printed below it
/// for R_v = 1000 R_m, 0.0009, is 0.000999.
///
/// ```
/// use taxel::circuit::simplified::v_in_protected;
/// assert!((v_in_protected(1.0, 1.0, 1000.0) - 0.000999).abs() < 1e-9);
/// ```
pub fn v_in_protected(v_test_volts: f64, r_path_ohms: f64, r_source_ohms: f64) -> f64 {
    v_test_volts / (1.0 + r_source_ohms / r_path_ohms)
}

/// Conductance of resistors in parallel, siemens.
fn siemens(ohms: &[f64]) -> f64 {
    // not sum(): of nothing that is -0.0, and R_L minus infinity
    ohms.iter().fold(0.0, |sum, r| sum + 1.0 / r)
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDEAL: Amplifier = Amplifier {
        open_loop_gain: f64::INFINITY,
        ..Amplifier::TABLE_V
    };
    const OTHERS: [f64; 3] = [500.0, 1000.0, 3000.0];

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12 * b.abs()
    }

    #[test]
    fn table_v_predicts_a_drop_of_two_hundred_thousandths_per_taxel() {
        let alone = v_out_alike(Amplifier::TABLE_V, 1000.0, 1000.0, 0);
        assert!(close(alone, -0.8));
        for others in 1..=127 {
            let drop = 1.0 - v_out_alike(Amplifier::TABLE_V, 1000.0, 1000.0, others) / alone;
            let first_order = others as f64 * 2e-5;
            assert!((drop - first_order).abs() <= first_order * first_order);
        }
    }

    #[test]
    fn equation_7_with_the_papers_ratio_is_0_000999() {
        assert_eq!(
            format!("{:.6}", v_in_protected(1.0, 1.0, 1000.0)),
            "0.000999"
        );
        assert_eq!(v_in_protected(0.4, f64::INFINITY, 1000.0), 0.4);
        assert_eq!(v_in_protected(0.4, 50.0, 0.0), 0.4);
    }

    #[test]
    fn infinite_gain_gives_the_ideal_amplifier() {
        let ideal = v_out_ideal(IDEAL, 700.0);
        assert!(close(ideal, -0.4 * 2000.0 / 700.0));
        assert!(close(v_out_one_taxel(IDEAL, 700.0), ideal));
        assert!(close(v_out_leak(IDEAL, 700.0, 10.0), ideal));
        assert!(close(v_out_leak_only(IDEAL, 700.0, 10.0), ideal));
        assert!(close(v_out_row(IDEAL, 700.0, &OTHERS), ideal));
        assert!(close(v_out_alike(IDEAL, 700.0, 1000.0, 127), ideal));
    }

    #[test]
    fn without_other_taxels_there_is_no_cross_talk() {
        let slow = Amplifier {
            open_loop_gain: 50.0,
            ..Amplifier::TABLE_V
        };
        let ideal = v_out_ideal(slow, 700.0);
        assert!(close(v_out_row(slow, 700.0, &[]), ideal));
        assert!(close(v_out_alike(slow, 700.0, 1000.0, 0), ideal));
        assert!(close(
            v_out_switched(slow, 700.0, 70.0, &[]),
            v_out_ideal(slow, 770.0)
        ));
        assert_eq!(
            v_out_leak(slow, 700.0, r_leak_ohms(&[])),
            v_out_one_taxel(slow, 700.0)
        );
    }

    #[test]
    fn equation_2_satisfies_kirchhoff_at_the_amplifiers_input() {
        let slow = Amplifier {
            open_loop_gain: 30.0,
            ..Amplifier::TABLE_V
        };
        let v_out = v_out_leak(slow, 700.0, 90.0);
        let v_in = -v_out / 30.0;
        let current = (0.4 - v_in) / 700.0 + (v_out - v_in) / 2000.0 - v_in / 90.0;
        assert!(current.abs() < 1e-15);
    }

    #[test]
    fn the_sums_of_equal_taxels_agree() {
        let slow = Amplifier {
            open_loop_gain: 50.0,
            ..Amplifier::TABLE_V
        };
        let row = v_out_row(slow, 700.0, &[900.0; 9]);
        assert!(close(row, v_out_alike(slow, 700.0, 900.0, 9)));
        assert!(close(row, v_out_leak_only(slow, 700.0, 100.0)));
        // as printed: A R_k R_i / ((A R_i + N R_k) R_taxel)
        let printed = -0.4 * 50.0 * 2000.0 * 900.0 / ((50.0 * 900.0 + 9.0 * 2000.0) * 700.0);
        assert!(close(row, printed));
    }
}
