//! ST NUCLEO-F446RE: Cortex-M4F at 180 MHz. The cheapest of these boards that runs the default
//! patch, which is copied to SRAM. Code stays in the flash, because fetches from SRAM are slower
//! than those from the flash's cache.
//!
//! | what | where |
//! |---|---|
//! | encoders x, y, z | PA0 and PA1, PC6 and PC7, PB6 and PB7 |
//! | magnitude x, y, z | PA8, PA9, PA10 |
//! | direction x, y, z | PB13, PB14, PB15 |
//! | stop circuit, enable, supply, operator | PB12, PC8, PC9, PC10 |
//! | link | USART2 (PA2, PA3) |
//! | light | LD2, PA5 |
//!
//! **Second watchdog.** The clock of the independent one (LSI) may be off by 50 % here: 4.5 ms may
//! be 8.5 ms. The window watchdog runs on the core's own clock, whose prescaler is not reset by a
//! feed: it acts after 3.6 to 4.4 ms. The independent one remains for the case that this clock
//! stops. A debugger that halts the core does not stop the window watchdog: whether the outputs of
//! a stopped TIM1 are off is documented for the other two chips and not for this one, so a halt
//! ends in a reset.

use embassy_stm32::interrupt;
use embassy_stm32::pac::Interrupt;
use embassy_stm32::pac::{
    DBGMCU, FLASH, GPIOA, GPIOB, GPIOC, IWDG, RCC, USART2, WWDG, iwdg::Iwdg, usart::Usart, wwdg::vals::Wdgtb,
};
use embassy_stm32::rcc::{AHBPrescaler, APBPrescaler, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::{Config, Peripherals, peripherals, rcc};

use super::{BoardPins, Pin, Stm32Board, bridge, encoders, input, link, output, prepare_watchdog, pulled_down, stop_input};

/// The NUCLEO-F446RE.
pub struct This;

super::handlers!(tick: TIM7, haptic: CAN2_TX, background: CAN2_RX0);

/// Six counts of 45 MHz / 4096 / 8: 4.37 ms. The watchdog acts when bit 6 falls.
const SECOND_WATCHDOG_START: u8 = 0x40 + 5;

impl Stm32Board for This {
    const NAME: &'static str = concat!("nucleo-f446re ", env!("CARGO_PKG_VERSION"));
    const PINS: BoardPins = BoardPins {
        enable: Pin { port: GPIOC, number: 8 },
        supply: Pin { port: GPIOC, number: 9 },
        operator: Pin { port: GPIOC, number: 10 },
        stop: Pin { port: GPIOB, number: 12 },
        directions: [Pin { port: GPIOB, number: 13 }, Pin { port: GPIOB, number: 14 }, Pin { port: GPIOB, number: 15 }],
        magnitudes: [Pin { port: GPIOA, number: 8 }, Pin { port: GPIOA, number: 9 }, Pin { port: GPIOA, number: 10 }],
        led: Pin { port: GPIOA, number: 5 },
    };
    const LINK: Usart = USART2;
    const TICK_INTERRUPT: Interrupt = Interrupt::TIM7;
    const EXECUTOR_INTERRUPTS: [Interrupt; 2] = [Interrupt::CAN2_TX, Interrupt::CAN2_RX0];
    const WATCHDOG: Iwdg = IWDG;

    fn clocks() -> Config {
        let mut config = Config::default();
        let rcc = &mut config.rcc;
        rcc.pll_src = PllSource::HSI;
        rcc.pll = Some(Pll {
            prediv: PllPreDiv::DIV8,
            mul: PllMul::MUL180, // 16 MHz / 8 x 180 / 2
            divp: Some(PllPDiv::DIV2),
            divq: None,
            divr: None,
        });
        rcc.sys = Sysclk::PLL1_P;
        rcc.ahb_pre = AHBPrescaler::DIV1;
        (rcc.apb1_pre, rcc.apb2_pre) = (APBPrescaler::DIV4, APBPrescaler::DIV2);
        config
    }

    fn clock_hz() -> u32 {
        180_000_000
    }

    #[cfg(feature = "self-test")]
    fn chip() -> (u32, [u8; 2]) {
        (DBGMCU.idcode().read().0, [FLASH.optcr().read().bor_lev(), 0])
    }

    fn wire(p: Peripherals) {
        output(p.PC8);
        input(p.PC9);
        input(p.PC10);
        output(p.PB13);
        output(p.PB14);
        output(p.PB15);
        output(p.PA5);
        stop_input(p.PB12, 1);
        let low = pulled_down;
        let (x, y) = (PwmPin::new_with_config(p.PA8, low()), PwmPin::new_with_config(p.PA9, low()));
        bridge::start(p.TIM1, x, y, PwmPin::new_with_config(p.PA10, low()));
        encoders::start(p.TIM2, p.PA0, p.PA1);
        encoders::start(p.TIM3, p.PC6, p.PC7);
        encoders::start(p.TIM4, p.PB6, p.PB7);
        encoders::filter();
        link::start(p.USART2, p.PA3, p.PA2);
        prepare_watchdog(p.IWDG);
    }

    fn freeze_with_debugger() {
        DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
        DBGMCU.apb1fzr().modify(|w| w.set_iwdg(true));
    }

    fn start_caches() {
        FLASH.acr().modify(|w| {
            w.set_prften(true);
            w.set_icen(true);
            w.set_dcen(true);
        });
    }

    fn reset_by_watchdog() -> bool {
        let cause = RCC.csr().read();
        RCC.csr().modify(|w| w.set_rmvf(true));
        cause.wdgrstf() || cause.wwdgrstf()
    }

    fn start_second_watchdog() {
        // waits until the watchdog has its clock: a write before that may be lost, and the reset
        // values mean 0.55 ms (erratum "delay after an RCC peripheral clock enabling")
        rcc::enable_and_reset::<peripherals::WWDG>();
        WWDG.cfr().write(|w| {
            w.set_wdgtb(Wdgtb::DIV8);
            w.set_w(0x7F);
        });
        Self::feed_second_watchdog();
    }

    fn feed_second_watchdog() {
        // opening a patch feeds the watchdogs, also before the tick timer runs, and must not start
        // this one
        if RCC.apb1enr().read().wwdgen() {
            WWDG.cr().write(|w| {
                w.set_t(SECOND_WATCHDOG_START);
                w.set_wdga(true);
            });
        }
    }
}
