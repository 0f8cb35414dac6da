//! Times frames in which many instances of some objects move to levels of their own on a graphics
//! device: all by `Crowd`, by `ResidentObject` in one submission, and by `ResidentObject` with a
//! submission each.
//!
//! `cargo run --release -p lodc --features gpu,build --example crowd -- 1000 A.lodc B.lodc …`

#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]

use lodc::gpu::{Crowd, Device, ResidentObject, wgpu};
use lodc::mesh::Lod;
use std::error::Error;
use std::time::Instant;

/// Frames that are timed, after one that is not.
const FRAMES: u32 = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let instances = words.next().ok_or("usage: crowd INSTANCES FILE.lodc…")?.parse()?;
    let files = words.map(lodc::open).collect::<Result<Vec<_>, _>>()?;
    let device = Device::open(None)?;
    println!("{}, {instances} instances of {} objects", device.adapter(), files.len());
    for (name, milliseconds) in measure(&device, &files, instances)? {
        println!("{name:<34} {milliseconds:9.3} ms a frame");
    }
    Ok(())
}

/// The level of an instance in a frame: over all frames each moves by a tenth of its levels, to and
/// fro, from a place of its own.
fn lod(records: u32, instance: usize, frame: u32) -> Lod {
    let from = (instance * 37 % 80) as u32;
    let share = from + (frame % 2) * 10;
    Lod((u64::from(records) * u64::from(share) / 100) as u32)
}

/// Mean milliseconds of a frame, from encoding to the end of the device's work, of each way.
fn measure(
    device: &Device,
    files: &[lodc::File],
    instances: usize,
) -> Result<Vec<(&'static str, f64)>, Box<dyn Error>> {
    let object = |number: usize| &files[number % files.len()].objects()[0];
    let records = |number| object(number).simplified.collapses().records();
    // Instance i is of object i modulo their number.
    let count = |number: usize| (instances + files.len() - 1 - number) / files.len();
    let mut crowds = Vec::new();
    let mut objects: Vec<ResidentObject> = Vec::new();
    for number in 0..files.len() {
        crowds.push(Crowd::new(device, object(number), count(number) as u32)?);
        objects.push(ResidentObject::new(device, object(number))?);
    }
    for i in files.len()..instances {
        objects.push(objects[i % files.len()].another()?);
    }
    let wait = || device.host().0.poll(wgpu::PollType::wait_indefinitely());

    let by_crowd = timed(|frame| {
        let mut encoder = device.encoder();
        for (number, crowd) in crowds.iter_mut().enumerate() {
            let own = (0..count(number)).map(|i| number + i * files.len());
            let lods: Vec<Lod> = own.map(|i| lod(records(number), i, frame)).collect();
            crowd.show(&mut encoder, &lods)?;
        }
        device.submit(encoder)?;
        wait()?;
        Ok(())
    })?;
    let at_once = timed(|frame| {
        let mut encoder = device.encoder();
        for (i, object) in objects.iter_mut().enumerate() {
            object.show(&mut encoder, lod(records(i), i, frame))?;
        }
        device.submit(encoder)?;
        wait()?;
        Ok(())
    })?;
    let each = timed(|frame| {
        for (i, object) in objects.iter_mut().enumerate() {
            let mut encoder = device.encoder();
            object.show(&mut encoder, lod(records(i), i, frame))?;
            device.submit(encoder)?;
        }
        wait()?;
        Ok(())
    })?;
    Ok(vec![
        ("Crowd, one submission", by_crowd),
        ("ResidentObject, one submission", at_once),
        ("ResidentObject, a submission each", each),
    ])
}

/// Mean milliseconds of a frame.
fn timed(mut frame: impl FnMut(u32) -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    frame(0)?;
    let start = Instant::now();
    (1..=FRAMES).try_for_each(&mut frame)?;
    Ok(start.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc::gpu::GpuError;

    #[test]
    fn every_way_takes_some_time() {
        let device = match Device::open(None) {
            Ok(device) => device,
            Err(GpuError::NoAdapter { .. }) if !lodc_fixtures::all_asked() => return,
            Err(error) => panic!("{error}"),
        };
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/");
        let file = |name| lodc::build(format!("{folder}{name}")).run().expect("a fixture");
        let files = ["terrain.glb", "machine_part.glb"].map(file);
        let figures = measure(&device, &files, 5).expect("small meshes");
        assert_eq!(figures.len(), 3);
        assert!(figures.iter().all(|&(_, milliseconds)| milliseconds > 0.0), "{figures:?}");
    }
}
