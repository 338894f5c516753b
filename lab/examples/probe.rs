//! probe
use effects::*;
use lab::*;
use std::path::Path;
use std::time::Instant;
use trials::trial::Campaign;
fn main() {
    let folder = std::env::args().nth(1).unwrap();
    let effect = std::env::args().nth(2).unwrap();
    let t = Instant::now();
    let c = Campaign::read(Path::new(&folder)).unwrap();
    eprintln!("read {:?}", t.elapsed());
    let lib = Library::builtin();
    let mut ev = ScanEvidence::new(&c.trials, None).unwrap();
    eprintln!("evidence {:?}", t.elapsed());
    let m = Model::new(ev.process());
    let a = Attempt::new(&mut ev, (&m, false), &lib, &effect).unwrap();
    eprintln!("attempt {:?}", t.elapsed());
    eprintln!("{} {} {:?} {}", a.before.chi2, a.with.chi2, a.paired, a.predicts_better_by);
    for e in a.with.estimates(1.0) {
        eprintln!("{} {} {}", e.coordinate.slot.name(), e.coordinate.slot.unit.from_si(e.value), e.sigma);
    }
}
