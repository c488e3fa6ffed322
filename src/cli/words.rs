//! A method's derived properties in plain words, and as JSON.

use kutta::tableau::{Evidence, Member, Properties, Stages, StiffOrder};
use serde_json::{Map, Value, json};

/// A line for each property that applies.
pub fn words(p: &Properties) -> String {
    let mut out = String::new();
    let mut line = |label: &str, text: String| out += &format!("{label:<16}{text}\n");
    let equation = match p.family {
        "IMEX pair" => "y' = f + g, g solved implicitly",
        "partitioned pair" => "q' = f(p), p' = g(q)",
        _ if p.second_order => "y'' = f(t, y)",
        _ => "y' = f(t, y)",
    };
    line("family", format!("{}, for {equation}", p.family));
    line("order", order(p));
    line("stages", stages(p));
    if let Some(q) = p.stage_order {
        line("stage order", q.to_string());
    }
    if let Some(stiff) = p.stiff_order {
        let of = if p.family == "IMEX pair" { "implicit table: " } else { "" };
        line("stiff problems", format!("{of}the error goes like {} (Prothero, Robinson)", left(stiff)));
    }
    line("local error", local_error(p));
    for m in &p.members {
        line(&format!("of order {}", m.order), member(m));
    }
    if let (Some(x), Some(y)) = (p.real_limit, p.imaginary_limit) {
        let of = if p.family == "IMEX pair" { " (explicit table)" } else { "" };
        line(
            "stable for",
            format!("h lambda on the real axis {}, on the imaginary axis {}{of}", from(x), upto(y)),
        );
    }
    if let Some(limit) = p.oscillation_limit {
        line("stable for", format!("h omega {}, where y'' = -omega^2 y", upto(limit)));
    }
    if let (Some(alpha), Some(at_infinity), Some(evidence)) = (p.alpha, p.at_infinity, p.evidence) {
        let of = if p.family == "IMEX pair" { "implicit table: " } else { "" };
        line("stability", format!("{of}{}", sector(alpha, at_infinity, evidence)));
    }
    if let Some(stiffly_accurate) = p.stiffly_accurate {
        line("last stage", format!("{}y' (stiffly accurate)", if stiffly_accurate { "" } else { "not " }));
    }
    if let Some(zero_stable) = p.zero_stable {
        line("zero-stable", yes(zero_stable).to_string());
    }
    if let Some(w_order) = p.w_order {
        line("W-method", inexact(p, w_order));
    }
    line(
        "rounding",
        format!("order conditions hold to {} in f64, {} in f32", miss(p.residual_f64), miss(p.residual_f32)),
    );
    let a = if p.max_a > 0.0 { format!(", largest |a| = {}", short(p.max_a)) } else { String::new() };
    line("weights", format!("sum |b| = {}{a}", short(p.sum_b)));
    for (order, blind) in p.embedded.iter().zip(&p.blind) {
        let sees =
            if *blind { "is blind to f(t): it is zero where f depends on t alone" } else { "sees f(t)" };
        line("error estimate", format!("of the embedded order {order} {sees}"));
    }
    if let Some(misses) = p.estimate_misses.filter(|&misses| misses > 2.0) {
        let of = if p.kind == Stages::Explicit { "linear equations" } else { "linear or of stiff equations" };
        line(
            "error estimate",
            format!("says too little of {of}: a step may err {} times as much", short(misses)),
        );
    }
    if let Some(symplectic) = p.symplectic {
        let symmetric = match p.symmetric {
            Some(true) => ", symmetric",
            Some(false) => ", not symmetric",
            None => "",
        };
        line("symplectic", format!("{}{symmetric}", yes(symplectic)));
    }
    let steppable = if p.steppable { "yes" } else { "not yet: it is read, proven and listed" };
    line("can be stepped", steppable.to_string());
    out
}

pub fn yes(x: bool) -> &'static str {
    if x { "yes" } else { "no" }
}

/// Five digits, zeros at the end left out; 1.2e-7 where it is small or large.
pub fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    if !(1e-3..1e5).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let decimals = (4 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

fn order(p: &Properties) -> String {
    let mut text = p.order.to_string();
    let embedded: Vec<_> = p.embedded.iter().map(usize::to_string).collect();
    if !embedded.is_empty() {
        text += &format!(", embedded {}", embedded.join(" and "));
    }
    if let Some(dense) = p.dense {
        text += &format!(", dense output {dense}");
    }
    text
}

/// What is left with any matrix in place of the Jacobian.
fn inexact(p: &Properties, w_order: usize) -> String {
    let embedded: String = p.w_embedded.iter().map(|order| format!(", embedded {order},")).collect();
    match w_order == p.order {
        true => format!("order {w_order}{embedded} with any matrix in place of the Jacobian"),
        false => format!("no, it needs the Jacobian: order {w_order}{embedded} with any other matrix"),
    }
}

fn stages(p: &Properties) -> String {
    let kind = match p.kind {
        _ if p.family == "IMEX pair" => "explicit for f, solved one after the other for g",
        Stages::Explicit => "explicit",
        Stages::Diagonal => "solved one after the other",
        Stages::Full => "solved all at once",
        Stages::Linear => "linear equations with the Jacobian, one after the other",
    };
    let evaluations = match (p.kind, p.evaluations) {
        (Stages::Explicit, 1) => "; 1 evaluation per step".to_string(),
        (Stages::Explicit | Stages::Linear, n) => format!("; {n} evaluations per step"),
        _ => String::new(),
    };
    let shared = if p.fsal { "; the last stage is the next step's first" } else { "" };
    format!("{}, {kind}{evaluations}{shared}", p.stages)
}

fn local_error(p: &Properties) -> String {
    let mut text = match p.error_constant {
        Some(c) if p.second_order => format!("{} h^{} y^({1})", short(c), p.order + 2),
        Some(c) => format!("{} h^{} y^({1})", short(c), p.order + 1),
        None => format!("{} h^{} (norm over the trees)", short(p.principal_error), p.order + 1),
    };
    for (order, error) in p.embedded.iter().zip(&p.embedded_errors) {
        text += &format!("; embedded {} h^{}", short(*error), order + 1);
    }
    text
}

/// l, the error and the sector of a member of a family.
fn member(m: &Member) -> String {
    let l: Vec<_> = m.l.iter().map(|l| short(l.hi())).collect();
    let sector = sector(m.alpha, m.at_infinity, m.evidence);
    let stiff = m.stiff_order.map_or(String::new(), |stiff| format!("; {} on stiff problems", left(stiff)));
    format!(
        "l = {}; {} h^{} y^({3}); {sector}{stiff}",
        l.join(" "),
        short(m.error_constant),
        m.order + 1,
        m.order + 1
    )
}

/// `h^3 / |lambda|`
fn left(stiff: StiffOrder) -> String {
    let over = match stiff.damping {
        0 => String::new(),
        1 => " / |lambda|".to_string(),
        m => format!(" / |lambda|^{m}"),
    };
    format!("h^{}{over}", stiff.order)
}

fn stiff_json(stiff: StiffOrder) -> Value {
    json!({ "order": stiff.order, "damping": stiff.damping })
}

fn from(x: f64) -> String {
    match x {
        0.0 => "nowhere".to_string(),
        f64::INFINITY => "everywhere left of 0".to_string(),
        x => format!("from -{} to 0", short(x)),
    }
}

fn upto(y: f64) -> String {
    match y {
        0.0 => "nowhere".to_string(),
        f64::INFINITY => "everywhere".to_string(),
        y => format!("up to {}", short(y)),
    }
}

fn sector(alpha: f64, at_infinity: f64, evidence: Evidence) -> String {
    let r = if at_infinity < 1e-9 { "0".to_string() } else { short(at_infinity) };
    let (is, at_infinity) = match alpha {
        90.0 if r == "0" => ("A-stable and L-stable".to_string(), String::new()),
        90.0 => ("A-stable".to_string(), format!("; |R| = {r} at infinity")),
        0.0 => ("in no sector about the negative real axis".to_string(), String::new()),
        alpha => (
            format!("A(alpha)-stable for alpha up to {alpha:.2} degrees"),
            format!("; |R| = {r} at infinity"),
        ),
    };
    let how = match evidence {
        Evidence::Proven => "proven".to_string(),
        Evidence::Found { degrees } => format!("found to {degrees:.0e} degrees"),
    };
    format!("{is} ({how}){at_infinity}")
}

/// `proven` or `found`, and the accuracy of an alpha that is found.
fn evidence_json(evidence: Evidence) -> (&'static str, Option<f64>) {
    match evidence {
        Evidence::Proven => ("proven", None),
        Evidence::Found { degrees } => ("found", Some(degrees)),
    }
}

fn miss(x: f64) -> String {
    if x == 0.0 { "the last bit".to_string() } else { format!("{x:.1e}") }
}

fn member_json(m: &Member) -> Value {
    let (evidence, within) = evidence_json(m.evidence);
    json!({
        "order": m.order,
        "l": m.l.iter().map(|l| l.hi()).collect::<Vec<_>>(),
        "error_constant": m.error_constant,
        "alpha": m.alpha,
        "evidence": evidence,
        "alpha_within": within,
        "at_infinity": m.at_infinity,
        "stiff_order": m.stiff_order.map(stiff_json),
    })
}

/// What applies, under the names of the library. JSON knows no infinity: it is the text `inf`.
pub fn json(p: &Properties) -> Map<String, Value> {
    let number = |x: f64| if x == f64::INFINITY { json!("inf") } else { json!(x) };
    let limit = |x: Option<f64>| x.map(number);
    let kind = match p.kind {
        Stages::Explicit => "explicit",
        Stages::Diagonal => "diagonal",
        Stages::Full => "full",
        Stages::Linear => "linear",
    };
    let (evidence, within) = p.evidence.map(evidence_json).unzip();
    let all = json!({
        "kind": kind,
        "second_order": p.second_order,
        "evaluations": p.evaluations,
        "fsal": p.fsal,
        "stiffly_accurate": p.stiffly_accurate,
        "stage_order": p.stage_order,
        "stiff_order": p.stiff_order.map(stiff_json),
        "principal_error": p.principal_error,
        "embedded_errors": p.embedded_errors,
        "error_constant": p.error_constant,
        "real_limit": limit(p.real_limit),
        "imaginary_limit": limit(p.imaginary_limit),
        "oscillation_limit": limit(p.oscillation_limit),
        "a_stable": p.a_stable,
        "l_stable": p.l_stable,
        "alpha": p.alpha,
        "evidence": evidence,
        "alpha_within": within.flatten(),
        "at_infinity": p.at_infinity,
        "zero_stable": p.zero_stable,
        "residual_f64": p.residual_f64,
        "residual_f32": p.residual_f32,
        "sum_b": p.sum_b,
        "max_a": p.max_a,
        "w_order": p.w_order,
        "w_embedded": p.w_order.map(|_| &p.w_embedded),
        "blind": p.blind,
        "estimate_misses": p.estimate_misses,
        "symplectic": p.symplectic,
        "symmetric": p.symmetric,
        "members": (!p.members.is_empty()).then(|| p.members.iter().map(member_json).collect::<Vec<_>>()),
    });
    let entries = all.as_object().cloned().unwrap_or_default();
    entries.into_iter().filter(|(_, value)| !value.is_null()).collect()
}
