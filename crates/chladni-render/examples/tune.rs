use chladni_frf::*;
use chladni_plate::*;
use chladni_render::*;
use num_complex::Complex64;
use std::path::Path;
struct Lcg(u64);
impl Lcg {
    fn u(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
    fn n(&mut self) -> f64 {
        (-2.0 * self.u().ln()).sqrt() * (std::f64::consts::TAU * self.u()).cos()
    }
}
fn perturb(m: &ModalModel, sw: f64, se: f64, sp: f64, iso: f64, seed: u64) -> ModalModel {
    let mut r = Lcg(seed * 7919 + 13);
    for _ in 0..5 {
        r.u();
    }
    let mut m = m.clone();
    for mode in &mut m.modes {
        if mode.in_band {
            let w = sw * r.n();
            mode.frequency_hz *= 1.0 + w;
            mode.frequency_std_hz = sw * mode.frequency_hz;
            mode.loss_factor *= 1.0 + se * r.n();
            mode.loss_factor_std = se * mode.loss_factor;
            for (s, d) in mode.shape.0.iter_mut().zip(&mut mode.shape_std) {
                let e = Complex64::new(r.n(), r.n()) * std::f64::consts::FRAC_1_SQRT_2 * sp;
                *d = sp * s.norm();
                *s *= 1.0 + e;
            }
            for s in mode.participation.0.iter_mut() {
                let e = Complex64::new(r.n(), r.n()) * std::f64::consts::FRAC_1_SQRT_2 * sp;
                *s *= 1.0 + e;
            }
        }
    }
    // residual error: iso
    if iso > 0.0 {
        let f = 300.0;
        let h = m.frf_matrix(FrfKind::Receptance, f);
        let rms = (h.iter().map(|v| v.norm_sqr()).sum::<f64>() / h.len() as f64).sqrt();
        let t = m.residual_terms.omega_scale_rad_per_s;
        let _ = t;
        let mat = h.mapv(|_| Complex64::new(r.n(), r.n()) * rms * iso * std::f64::consts::FRAC_1_SQRT_2);
        m.residual_terms.terms.push(ResidualTerm { power: 0, matrix: ComplexMatrix(mat) });
    }
    m
}
fn scene(hot: usize, f: f64) -> Scene {
    let g = std::env::var("GRID").unwrap_or("2, 2".into());
    Scene::parse(&format!("frequency_hz={f}\n[zones]\ngrid=[{g}]\nhot=[{hot}]\ncells_m=[0.0,0.0,0.268,0.170]\n"), Path::new("")).unwrap()
}
fn dense(plate: &DampedPlate, w: &Weights, r: &Rendering, f: f64, refs: &[[f64; 2]]) -> (f64, f64) {
    let mut pts = vec![];
    for j in 0..=24 {
        for i in 0..=40 {
            pts.push([0.034 + 0.005 * i as f64, 0.025 + 0.005 * j as f64]);
        }
    }
    let h = plate.mobility_matrix(&pts, refs, f).unwrap();
    let a: ndarray::Array1<Complex64> = w.weights.iter().map(|w| w.value()).collect();
    let v = h.dot(&a);
    let (mut nh, mut nc, mut h_, mut c_) = (0, 0, 0, 0);
    for (p, v) in pts.iter().zip(&v) {
        match r.zones.classify(*p) {
            Ground::Hot => {
                nh += 1;
                if r.limits.is_felt(v.norm()) {
                    h_ += 1
                }
            }
            Ground::Cold => {
                nc += 1;
                if r.limits.is_quiet(v.norm()) {
                    c_ += 1
                }
            }
            _ => {}
        }
    }
    (h_ as f64 / nh as f64, c_ as f64 / nc as f64)
}
fn main() {
    let f: f64 = std::env::var("F").ok().map_or(300.0, |s| s.parse().unwrap());
    let panel = Panel::default();
    let sim = simulate(&panel, None, None).unwrap();
    let refs = panel.layout().references_m;
    let truth = &sim.truth;
    let (sw, se, sp, iso) = (2e-5, 2e-3, 3e-3, 2e-3);
    let hots: Vec<usize> = std::env::var("HOT").unwrap_or("1 2 3 4".into()).split(' ').map(|s| s.parse().unwrap()).collect();
    for method in [Method::PressureMatching, Method::Mls] {
        let mut opts = RenderOptions { method, ..Default::default() };
        if let Ok(s) = std::env::var("DRIFT") {
            let v: Vec<f64> = s.split(' ').map(|x| x.parse().unwrap()).collect();
            opts.drift = Drift { frequency_relative: v[0], loss_factor_relative: v[1], shape_relative: v[2], isotropic_relative: v[3] };
        }
        for &hot in &hots {
            let sc = scene(hot, f);
            let (mut sh, mut sc_, mut sd, mut sdc, mut dh, mut dc, mut fm, mut kap, mut dm) =
                (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0f64, 0.0, 0.0);
            let n = 4;
            let mut worst = 1.0f64;
            let mut wd = 1.0f64;
            let mut t = 0.0;
            for seed in 0..n {
                let m = perturb(truth, sw, se, sp, iso, seed + 1);
                let t0 = std::time::Instant::now();
                let r = render(&m, &sc, &opts).unwrap();
                t += t0.elapsed().as_secs_f64();
                if seed == 0 && std::env::var("V").is_ok() {
                    println!("{:?}", r.weights.warnings)
                }
                let e = evaluate(&r.weights, &sc, On::Model(truth)).unwrap();
                sh += e.indices.points.hot_ratio;
                sc_ += e.indices.points.cold_ratio;
                worst = worst.min(e.indices.points.min_ratio);
                let (a, b) = dense(&sim.plate, &r.weights, &r, f, &refs);
                sd += a;
                sdc += b;
                fm = fm.max(r.weights.indices.points.max_force_n.unwrap());
                kap += r.weights.kappa.unwrap();
                dm += r.weights.indices.points.min_ratio;
                for k in 0..5 {
                    let d = perturb(truth, 1e-3, 0.1, 0.0, 0.0, 100 + seed * 10 + k);
                    let e = evaluate(&r.weights, &sc, On::Model(&d)).unwrap();
                    dh += e.indices.points.hot_ratio / 5.0;
                    dc += e.indices.points.cold_ratio / 5.0;
                    wd = wd.min(e.indices.points.min_ratio);
                }
            }
            let n = n as f64;
            println!("{method} hot{hot}: model min {:.3} | truth hot {:.3} cold {:.3} worst {:.3} | dense hot {:.3} cold {:.3} | drift hot {:.3} cold {:.3} worst {:.3} | F {:.4} kappa {:.2} t {:.1} ms",dm/n,sh/n,sc_/n,worst,sd/n,sdc/n,dh/n,dc/n,wd,fm,kap/n,t/n*1e3);
        }
    }
}
