//! ST NUCLEO-G474RE: Cortex-M4F at 170 MHz, with additional timers and analog inputs for motor
//! control. The tick is in CCM and the patch in SRAM, since the flash waits four cycles for each
//! eight bytes.
//!
//! | what | where |
//! |---|---|
//! | encoders x, y, z | PA0 and PA1, PC6 and PC7, PB6 and PB7 |
//! | magnitude x, y, z | PA8, PA9, PA10 |
//! | direction x, y, z | PB13, PB14, PB15 |
//! | stop circuit, enable, supply, operator | PB12, PC8, PC9, PC10 |
//! | link | USART2 (PA2, PA3) |
//! | light | LD2, PA5 |

use embassy_stm32::interrupt;
use embassy_stm32::pac::Interrupt;
use embassy_stm32::pac::{DBGMCU, FLASH, GPIOA, GPIOB, GPIOC, IWDG, RCC, USART2, iwdg::Iwdg, usart::Usart};
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::{Config, Peripherals};

use super::{BoardPins, Pin, Stm32Board, bridge, encoders, input, link, output, prepare_watchdog, pulled_down, stop_input};

/// The NUCLEO-G474RE.
pub struct This;

super::handlers!(tick: TIM7_DAC, haptic: FDCAN2_IT0, background: FDCAN2_IT1);

impl Stm32Board for This {
    const NAME: &'static str = concat!("nucleo-g474re ", env!("CARGO_PKG_VERSION"));
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
    const TICK_INTERRUPT: Interrupt = Interrupt::TIM7_DAC;
    const EXECUTOR_INTERRUPTS: [Interrupt; 2] = [Interrupt::FDCAN2_IT0, Interrupt::FDCAN2_IT1];
    const WATCHDOG: Iwdg = IWDG;

    fn clocks() -> Config {
        let mut config = Config::default();
        let rcc = &mut config.rcc;
        rcc.pll = Some(Pll {
            source: PllSource::HSI,
            prediv: PllPreDiv::DIV4,
            mul: PllMul::MUL85, // 16 MHz / 4 x 85 / 2
            divp: None,
            divq: None,
            divr: Some(PllRDiv::DIV2),
        });
        rcc.sys = Sysclk::PLL1_R;
        rcc.boost = true; // above 150 MHz
        config
    }

    fn clock_hz() -> u32 {
        170_000_000
    }

    #[cfg(feature = "self-test")]
    fn chip() -> (u32, [u8; 2]) {
        (DBGMCU.idcode().read().0, [FLASH.optr().read().bor_lev(), 4])
    }

    fn wire(p: Peripherals) {
        output(p.PC8);
        input(p.PC9);
        input(p.PC10);
        output(p.PB13);
        output(p.PB14);
        output(p.PB15);
        output(p.PA5);
        stop_input(p.PB12, 6);
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
        DBGMCU.apb2fzr().modify(|w| w.set_tim1(true)); // a frozen TIM1 drives its outputs as if MOE were clear
        DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
    }

    fn start_caches() {
        FLASH.acr().modify(|w| {
            w.set_prften(true);
            w.set_icen(true);
            w.set_dcen(true);
        });
    }

    fn reset_by_watchdog() -> bool {
        let by_watchdog = RCC.csr().read().iwdgrstf();
        RCC.csr().modify(|w| w.set_rmvf(true));
        by_watchdog
    }
}
