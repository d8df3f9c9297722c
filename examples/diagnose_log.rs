//! Names the physical effect that a rigid body lacks, from a log of joint position and torque:
//!
//!     cargo run --release --example diagnose_log -- my-log.csv

use torquescope::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<_> = std::env::args_os().skip(1).map(Into::into).collect();
    let monitor = Monitor::new();
    // The arm hangs at q = 0; columns are found by their names, and what is not measured is derived.
    let options = ReadOptions { zero: Some(Posture::DOWN), ..ReadOptions::default() };
    let opened = Command::open(files, options, HoldOut::default()).run(&Session::default(), &monitor)?;
    let diagnosed = Command::Diagnose.run(&opened, &monitor)?;
    let report = diagnosed.report.ok_or("there is no report")?;
    println!("{:?}; held-out nMSE by joint {:?}", report.verdict, report.held_out_nmse);
    for named in &report.effects {
        let joints = joints_text(&named.joints);
        println!("{} on {joints}: {:.0} %, then {:?}", named.effect.name, 100.0 * named.presence, named.nmse_after);
    }
    Ok(())
}
