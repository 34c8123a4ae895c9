//! Presses a string and lets it go, in Rust: poses in, forces and tones out. For a daemon in virtual time with a scripted device:
//!   hapticd --clock virtual --device scripted
//! rustc --edition 2021 press.rs && ./press [HOST:PORT]
#[allow(dead_code)]
mod hapticd;

const TICKS: usize = 600;

/// Beside the string, down, across it, which plucks it, and up again.
fn pluck() -> Vec<hapticd::Pose> {
    (0..TICKS)
        .map(|tick| {
            let s = tick as f64 / (TICKS - 1) as f64;
            let y = 0.0153 - 0.0113 * f64::min(1.0, 4.0 * f64::min(s, 1.0 - s));
            let z = -0.012 + 0.024 * f64::min(1.0, f64::max(0.0, 2.0 * s - 0.5));
            hapticd::Pose { p_m: [0.0, y, z], q: [1.0, 0.0, 0.0, 0.0] }
        })
        .collect()
}

fn play(server: &str) -> Result<(), hapticd::Error> {
    let mut session = hapticd::Session::open(server)?;
    session.acquire("press")?;
    session.load_scene("single_string")?;
    session.subscribe(1)?;
    let result = session.run(TICKS as u64, &pluck())?;
    let mut largest = 0.0f64;
    while let Some(state) = session.next_state()? {
        let f = state.tools[0].wrench_h_w;
        largest = largest.max(f[..3].iter().map(|f| f64::from(*f).powi(2)).sum::<f64>().sqrt());
    }
    while let Some(event) = session.next_event()? {
        if event.kind == hapticd::EVENT_TONE {
            println!("string {} sounds at {:.2} Hz after {:.3} ms", event.string_index, event.frequency_hz, event.t_ns as f64 * 1e-6);
        }
    }
    let hash: String = result.state_hash.iter().map(|byte| format!("{byte:02x}")).collect();
    println!("{} ticks, largest force {:.4} N, state hash {}", result.steps, largest, hash);
    Ok(())
}

fn main() {
    let server = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:47800".into());
    if let Err(error) = play(&server) {
        eprintln!("press: {}", error.message);
        std::process::exit(1);
    }
}
