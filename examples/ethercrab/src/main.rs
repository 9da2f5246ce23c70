// SPDX-License-Identifier: MIT
//! EtherCrab as master of twins in the same process: no socket, no right, no second program.
//!
//! usage: ethercrab-chain [OPTION...] DEVICE[,DEVICE...]    options as those of `ectwin with`

mod bus;

use bus::Bus;
use ethercrab::{error::Error, std::ethercat_now, MainDevice, MainDeviceConfig, PduRx, PduStorage, PduTx, Timeouts};
use std::{cell::RefCell, future::poll_fn, process::ExitCode, task::Poll, time::Instant};

const CYCLES: u32 = 1000;
static STORAGE: PduStorage<16, { PduStorage::element_size(1100) }> = PduStorage::new();

/// The network: each frame of the master goes through the bus, and its replies back, at once.
async fn network(bus: &RefCell<Bus>, start: Instant, mut tx: PduTx<'_>, mut rx: PduRx<'_>) -> Result<(), Error> {
    poll_fn(|context| {
        tx.replace_waker(context.waker());
        let now_ns = start.elapsed().as_nanos() as u64;
        let mut bus = bus.borrow_mut();
        bus.run(now_ns);
        while let Some(frame) = tx.next_sendable_frame() {
            let mut sent = Vec::new();
            frame.send_blocking(|data| {
                sent.extend_from_slice(data);
                Ok(data.len())
            })?;
            bus.frame(&sent, now_ns);
            while let Some(reply) = bus.reply() {
                rx.receive_frame(&reply)?;
            }
        }
        Poll::Pending
    })
    .await
}

async fn master(bus: &RefCell<Bus>, device: MainDevice<'_>) -> Result<(), Error> {
    let group = device.init_single_group::<16, 1024>(ethercat_now).await?;
    let group = group.into_safe_op(&device).await?.request_into_op(&device).await?;
    for slave in group.iter(&device) {
        let io = slave.io_raw();
        println!("{}: {} bytes in, {} bytes out", slave.name(), io.inputs().len(), io.outputs().len());
    }
    while !group.tx_rx(&device).await?.all_op() {}
    let begin = Instant::now();
    for _ in 0..CYCLES {
        group.tx_rx(&device).await?;
    }
    println!("{CYCLES} cycles in OP, {} us each", begin.elapsed().as_micros() / u128::from(CYCLES));
    println!("ecat.state = {}", bus.borrow().get(1, "ecat.state").unwrap_or_default());
    Ok(())
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let bus = match Bus::open(&words, 0) {
        Ok(bus) => RefCell::new(bus),
        Err(reason) => {
            eprintln!("ethercrab-chain: {reason}");
            return ExitCode::FAILURE;
        }
    };
    let (tx, rx, pdu_loop) = STORAGE.try_split().expect("split once");
    let device = MainDevice::new(pdu_loop, Timeouts::default(), MainDeviceConfig::default());
    let result = smol::block_on(smol::future::or(network(&bus, Instant::now(), tx, rx), master(&bus, device)));
    if let Err(error) = result {
        eprintln!("ethercrab-chain: {error:?}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
