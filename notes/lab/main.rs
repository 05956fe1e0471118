#![allow(dead_code)]
#[path = "score.rs"]
mod score;
use faer::Mat;
use score::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    for f in &args[1..] {
        let text = std::fs::read_to_string(f).unwrap();
        let mut lines = text.lines();
        let known = lines.next().unwrap() == "1";
        fn mat<'a>(lines: &mut impl Iterator<Item = &'a str>) -> Mat<f64> {
            let d: Vec<usize> = lines.next().unwrap().split(' ').map(|x| x.parse().unwrap()).collect();
            let v: Vec<f64> = lines.next().unwrap().split_whitespace().map(|x| x.parse().unwrap()).collect();
            Mat::from_fn(d[0], d[1], |i, j| v[j * d[0] + i])
        }
        let residual = mat(&mut lines);
        let basis = mat(&mut lines);
        let columns = mat(&mut lines);
        let prior = mat(&mut lines);
        let names: Vec<String> = lines.next().unwrap().split(' ').map(|s| s.to_string()).collect();
        let n: usize = lines.next().unwrap().parse().unwrap();
        let kernels: Vec<Kernel> = (0..n).map(|_| { let name = lines.next().unwrap().to_string(); Kernel { name, factor: mat(&mut lines) } }).collect();
        let r: Vec<f64> = residual.col(0).iter().copied().collect();
        let extra: f64 = std::env::var("EXTRA").map_or(5.0, |v| v.parse().unwrap()); let p: Vec<f64> = prior.col(0).iter().map(|v| v + extra.ln()).collect();
        let problem = Problem { residual: &r, basis: basis.as_ref(), columns: columns.as_ref(), prior: &p, known, kernels: &kernels };
        println!("== {f} known {known} n {} k {}", r.len(), p.len());
        for k in &kernels {
            let mut g = k.factor.clone();
            for _ in 0..2 { let a = basis.transpose() * &g; g -= &basis * a; }
            let s = (g.transpose() * &g).self_adjoint_eigen(faer::Side::Lower).unwrap();
            let mut s: Vec<f64> = s.S().column_vector().iter().copied().collect();
            s.sort_by(|a, b| b.total_cmp(a));
            let sum: f64 = s.iter().sum(); let sq: f64 = s.iter().map(|x| x * x).sum();
            println!("  kernel {} part {:.1} {:?}", k.name, sum * sum / sq, s.iter().take(8).map(|x| format!("{:.2}", x)).collect::<Vec<_>>());
        }
        let t = std::time::Instant::now();
        let mut score = Score::new(&problem, Priors::at(0.01));
        score.search(&[]);
        let posterior = score.posterior();
        println!("  nothing {:.3} outside {:.3} ({:.2} s)", posterior.nothing, posterior.outside, t.elapsed().as_secs_f64());
        for (p, set) in posterior.sets.iter().take(10) {
            let own: Vec<String> = score.visited.iter().filter(|((_, s), v)| s == set && **v > score.best - 9.0).map(|((k, _), v)| format!("{} {:.1}", if *k == 0 { "none".to_string() } else { score.names[*k as usize - 1].clone() }, v - score.best)).collect();
            println!("   {p:.4} {} | {}", set.iter().map(|j| names[*j as usize].clone()).collect::<Vec<_>>().join(" + "), own.join(", "));
        }
        for c in &posterior.classes { println!("   class {:.4} {:?}", c.probability, c.members.iter().take(6).map(|(j, p)| format!("{} {p:.1e}", names[*j])).collect::<Vec<_>>()); }
    }
}
