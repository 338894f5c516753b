//! Scratch.
use robofin::laboratory::*;
use robofin::trial::{Campaign, PassScan};
use sim::effect::{CompiledModel, Library, Model};
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let c = Campaign::read(std::path::Path::new(&name)).unwrap();
    let ev = ScanEvidence::new(&c.trials, None).unwrap();
    let model = Model::parse("m", &std::env::var("MODEL").unwrap(), Library::builtin()).unwrap();
    let model = CompiledModel::new(&model, Library::builtin(), ev.rows()).unwrap();
    let passes = ev.simulate(&model, Split::Calibration).unwrap();
    let blur = ev.blur_of(&passes, &model).unwrap();
    let passes = ev.simulate(&model, Split::Evaluation).unwrap();
    for view in ev.of(Split::Evaluation).chain(ev.of(Split::Calibration).take(2)) {
        let (ScanData::Heights(data), PassScan::Heights(sim)) = (&view.data, &passes[view.trial][view.pass].scan) else { panic!() };
        let d = data.left(&ev.seen(view, sim, blur));
        let m = &data.measured;
        let (nx, ny) = (m.pixels.nx, m.pixels.ny);
        let mut bx = vec![(0.0, 0.0); 20];
        let mut by = vec![(0.0, 0.0); ny];
        for (_, at) in data.tiles.pixels() {
            if !d[at].is_finite() { continue; }
            let (i, j) = (at % nx, at / nx);
            let b = &mut bx[i * 20 / nx]; b.0 += d[at]; b.1 += 1.0;
            let b = &mut by[j]; b.0 += d[at]; b.1 += 1.0;
        }
        println!("trial {} pass {}", view.trial + 1, view.pass + 1);
        println!(" x: {:?}", bx.iter().map(|b| (b.0 / b.1 * 1e7).round() / 10.0).collect::<Vec<_>>());
        println!(" y: {:?}", by.iter().filter(|b| b.1 > 50.0).map(|b| (b.0 / b.1 * 1e7).round() / 10.0).collect::<Vec<_>>());
    }
}
