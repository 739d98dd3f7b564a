//! The window.

#[cfg(not(target_family = "wasm"))]
fn main() -> std::process::ExitCode {
    window::open()
}

#[cfg(target_family = "wasm")]
fn main() {}

#[cfg(not(target_family = "wasm"))]
mod window {
    use std::process::ExitCode;

    use clap::Parser;
    use eframe::egui;
    use palpate_live::app::App;
    use palpate_live::link::thread::Thread;
    use palpate_sim::live::{Choice, Holding};

    /// Press tissue with the mouse.
    #[derive(Parser)]
    #[command(name = "palpate live")]
    struct Arguments {
        /// A preset or the path of a scene file (.toml).
        #[arg(long, value_name = "NAME|FILE", default_value = "block")]
        scene: String,
    }

    pub fn open() -> ExitCode {
        let arguments = Arguments::parse();
        let choice = Choice::preset(&arguments.scene);
        let holding = Holding { hand: "H2".into(), ..Holding::default() };
        if let Err(error) = choice.scene() {
            eprintln!("palpate: {error}");
            return ExitCode::from(2);
        }
        let size = egui::vec2(1280.0, 720.0);
        let viewport = egui::ViewportBuilder::default().with_inner_size(size).with_title("Palpate live").with_app_id("palpate");
        let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
        let link = Thread::start(choice.clone(), holding.clone());
        let made = eframe::run_native(
            "Palpate live",
            options,
            Box::new(|cc| Ok(Box::new(App::new(&cc.egui_ctx, Box::new(link), choice, holding)))),
        );
        match made {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("palpate: no window: {error}: start it on a desktop, or take the page, `palpate live --page`");
                ExitCode::from(2)
            }
        }
    }
}
