//! Text for LaTeX, of any engine: what its fonts lack is set as formulas.

use std::iter::Peekable;
use std::str::Chars;

/// A text as LaTeX reads it. Needs no package.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match accent(&mut letters) {
            Some(accent) => {
                escaped.push_str(&format!("$\\{accent}{{{}}}$", formula(letter).unwrap_or(&letter.to_string())))
            }
            None => match (plain(letter), formula(letter)) {
                (Some(plain), _) => escaped.push_str(plain),
                (None, Some(formula)) => escaped.push_str(&format!("${formula}$")),
                (None, None) if "&%$#_{}".contains(letter) => escaped.extend(['\\', letter]),
                (None, None) => escaped.push(letter),
            },
        }
    }
    escaped
}

/// The accent above a letter, which stands behind it.
fn accent(letters: &mut Peekable<Chars>) -> Option<&'static str> {
    let accent = match letters.peek()? {
        '\u{302}' => "hat",
        '\u{303}' => "tilde",
        '\u{304}' => "bar",
        '\u{307}' => "dot",
        '\u{308}' => "ddot",
        _ => return None,
    };
    letters.next();
    Some(accent)
}

/// What stands in text.
fn plain(letter: char) -> Option<&'static str> {
    Some(match letter {
        '\\' => "\\textbackslash{}",
        '^' => "\\textasciicircum{}",
        '~' => "\\textasciitilde{}",
        '…' => "\\dots{}",
        '–' => "--",
        '—' => "---",
        '“' => "``",
        '”' => "''",
        '’' => "'",
        _ => return None,
    })
}

/// What stands in a formula.
fn formula(letter: char) -> Option<&'static str> {
    Some(match letter {
        'α' => "\\alpha",
        'β' => "\\beta",
        'γ' => "\\gamma",
        'δ' => "\\delta",
        'Δ' => "\\Delta",
        'ε' => "\\varepsilon",
        'ζ' => "\\zeta",
        'η' => "\\eta",
        'θ' => "\\theta",
        'κ' => "\\kappa",
        'λ' => "\\lambda",
        'μ' | 'µ' => "\\mu",
        'ν' => "\\nu",
        'ξ' => "\\xi",
        'π' => "\\pi",
        'ρ' => "\\rho",
        'σ' => "\\sigma",
        'Σ' => "\\Sigma",
        'τ' => "\\tau",
        'φ' => "\\varphi",
        'χ' => "\\chi",
        'ψ' => "\\psi",
        'ω' => "\\omega",
        'Ω' => "\\Omega",
        '⁰' => "^0",
        '¹' => "^1",
        '²' => "^2",
        '³' => "^3",
        '⁴' => "^4",
        '⁻' => "^-",
        'ᵀ' => "^T",
        'ⁿ' => "^n",
        '₀' => "_0",
        '₁' => "_1",
        '₂' => "_2",
        '₃' => "_3",
        '₄' => "_4",
        '₅' => "_5",
        '₆' => "_6",
        '₇' => "_7",
        'ᵢ' => "_i",
        'ⱼ' => "_j",
        'ₖ' => "_k",
        'ₙ' => "_n",
        '·' | '⋅' => "\\cdot",
        '×' => "\\times",
        '±' => "\\pm",
        '−' => "-",
        '<' => "<",
        '>' => ">",
        '|' => "|",
        '‖' => "\\|",
        '≤' => "\\leq",
        '≥' => "\\geq",
        '≈' => "\\approx",
        '≠' => "\\neq",
        '∝' => "\\propto",
        '→' => "\\to",
        '←' => "\\leftarrow",
        '↑' => "\\uparrow",
        '↓' => "\\downarrow",
        'ℒ' => "\\mathcal{L}",
        '÷' => "\\div",
        '∂' => "\\partial",
        '∫' => "\\int",
        '√' => "\\surd",
        '∞' => "\\infty",
        '½' => "\\frac12",
        '¼' => "\\frac14",
        '°' => "^\\circ",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_of_latex_and_letters_that_its_fonts_lack_are_written_out() {
        assert_eq!(escaped("a_b & 50 % [N m]"), "a\\_b \\& 50 \\% [N m]");
        assert_eq!(escaped("τ̂ of q̈, rad/s²"), "$\\hat{\\tau}$ of $\\ddot{q}$, rad/s$^2$");
        assert_eq!(escaped("1 … 2 – 3 < 4"), "1 \\dots{} 2 -- 3 $<$ 4");
    }
}
