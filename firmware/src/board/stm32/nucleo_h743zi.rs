//! ST NUCLEO-H743ZI and NUCLEO-H743ZI2: Cortex-M7 at 480 MHz, or at 400 MHz on silicon before
//! revision X, which the older of the two boards carries. The image is built for the M7
//! (`.cargo/config.toml`). The tick is in ITCM, patch and state are in DTCM, and an uploaded patch
//! is in AXI SRAM behind the data cache.
//!
//! | what | where |
//! |---|---|
//! | encoders x, y, z | PA15 and PB3, PC6 and PC7, PD12 and PD13 |
//! | magnitude x, y, z | PE9, PE11, PE13 |
//! | direction x, y, z | PF3, PF5, PF10 |
//! | stop circuit, enable, supply, operator | PE15, PF12, PF13, PF14 |
//! | link | USART3 (PD8, PD9) |
//! | light | LD1, PB0 |
//!
//! PB3 is also the debugger's trace output (SWO): there is no trace while encoder x is connected.

use embassy_stm32::interrupt;
use embassy_stm32::pac::Interrupt;
use embassy_stm32::pac::{DBGMCU, GPIOB, GPIOE, GPIOF, IWDG1, RCC, USART3, iwdg::Iwdg, usart::Usart};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, HSIPrescaler, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk, VoltageScale,
};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::{Config, Peripherals};

use super::{BoardPins, Pin, Stm32Board, bridge, encoders, input, link, output, prepare_watchdog, pulled_down, stop_input};

/// The NUCLEO-H743ZI and ZI2.
pub struct This;

super::handlers!(tick: TIM7, haptic: UART7, background: UART8, link: USART3);

/// Revisions that run at 480 MHz: X and V. All others, including unknown ones, run at 400 MHz.
const FAST_REVISIONS: [u16; 2] = [0x2001, 0x2003];

/// Number of reads in flight on the interconnect's port to AXI SRAM; the chip's description lacks
/// this register.
const AXI_SRAM_READ_ISSUING: *mut u32 = 0x5100_8108 as *mut u32;

fn is_fast() -> bool {
    FAST_REVISIONS.contains(&DBGMCU.idc().read().rev_id())
}

impl Stm32Board for This {
    const NAME: &'static str = concat!("nucleo-h743zi ", env!("CARGO_PKG_VERSION"));
    const PINS: BoardPins = BoardPins {
        enable: Pin { port: GPIOF, number: 12 },
        supply: Pin { port: GPIOF, number: 13 },
        operator: Pin { port: GPIOF, number: 14 },
        stop: Pin { port: GPIOE, number: 15 },
        directions: [Pin { port: GPIOF, number: 3 }, Pin { port: GPIOF, number: 5 }, Pin { port: GPIOF, number: 10 }],
        magnitudes: [Pin { port: GPIOE, number: 9 }, Pin { port: GPIOE, number: 11 }, Pin { port: GPIOE, number: 13 }],
        led: Pin { port: GPIOB, number: 0 },
    };
    const LINK: Usart = USART3;
    const LINK_INTERRUPT: Interrupt = Interrupt::USART3;
    const TICK_INTERRUPT: Interrupt = Interrupt::TIM7;
    const EXECUTOR_INTERRUPTS: [Interrupt; 2] = [Interrupt::UART7, Interrupt::UART8];
    const WATCHDOG: Iwdg = IWDG1;

    fn clocks() -> Config {
        let (scale, mul) = if is_fast() { (VoltageScale::Scale0, PllMul::MUL60) } else { (VoltageScale::Scale1, PllMul::MUL50) };
        let mut config = Config::default();
        let rcc = &mut config.rcc;
        rcc.hsi = Some(HSIPrescaler::DIV1);
        rcc.pll1 = Some(Pll {
            source: PllSource::HSI,
            prediv: PllPreDiv::DIV4,
            mul, // 64 MHz / 4 x 60 / 2, or x 50
            fracn: None,
            divp: Some(PllDiv::DIV2),
            divq: None,
            divr: None,
        });
        rcc.sys = Sysclk::PLL1_P;
        rcc.ahb_pre = AHBPrescaler::DIV2;
        (rcc.apb1_pre, rcc.apb2_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
        (rcc.apb3_pre, rcc.apb4_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
        rcc.voltage_scale = scale;
        config
    }

    fn clock_hz() -> u32 {
        if is_fast() { 480_000_000 } else { 400_000_000 }
    }

    #[cfg(feature = "self-test")]
    fn chip() -> (u32, [u8; 2]) {
        (DBGMCU.idc().read().0, [embassy_stm32::pac::FLASH.optsr_cur().read().bor_lev(), 3])
    }

    fn wire(p: Peripherals) {
        output(p.PF12);
        input(p.PF13);
        input(p.PF14);
        output(p.PF3);
        output(p.PF5);
        output(p.PF10);
        output(p.PB0);
        stop_input(p.PE15, 1);
        let low = pulled_down;
        let (x, y) = (PwmPin::new_with_config(p.PE9, low()), PwmPin::new_with_config(p.PE11, low()));
        bridge::start(p.TIM1, x, y, PwmPin::new_with_config(p.PE13, low()));
        encoders::start(p.TIM2, p.PA15, p.PB3);
        encoders::start(p.TIM3, p.PC6, p.PC7);
        encoders::start(p.TIM4, p.PD12, p.PD13);
        encoders::filter();
        link::start(p.USART3, p.PD9, p.PD8);
        prepare_watchdog(p.IWDG1);
    }

    fn freeze_with_debugger() {
        DBGMCU.apb2fzr1().modify(|w| w.set_tim1(true)); // a frozen TIM1 drives its outputs as if MOE were clear
        DBGMCU.apb4fzr1().modify(|w| w.set_iwdg1(true));
    }

    fn reset_by_watchdog() -> bool {
        let by_watchdog = RCC.rsr().read().iwdg1rstf();
        RCC.rsr().modify(|w| w.set_rmvf(true));
        by_watchdog
    }

    fn start_caches() {
        if !is_fast() {
            // erratum ES0392 2.2.9: on revision Y, reads from AXI SRAM may return wrong data
            // SAFETY: a register of the interconnect, which ST's start-up code sets as well.
            unsafe { AXI_SRAM_READ_ISSUING.write_volatile(1) };
        }
        // SAFETY: called once, before any task runs; no other code owns these peripherals, and no
        // DMA changes memory behind the caches.
        let mut core = unsafe { cortex_m::Peripherals::steal() };
        core.SCB.enable_icache();
        core.SCB.enable_dcache(&mut core.CPUID);
    }

    fn discard_caches() {
        // SAFETY: as in `start_caches`.
        let mut core = unsafe { cortex_m::Peripherals::steal() };
        core.SCB.clean_invalidate_dcache(&mut core.CPUID);
    }
}
