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
    use palpate_loop::live::{Choice, Holding};

    /// Press tissue with the mouse.
    #[derive(Parser)]
    #[command(name = "palpate live")]
    struct Arguments {
        /// A preset or the path of a scene file (.toml).
        #[arg(long, value_name = "NAME|FILE", default_value = "block")]
        scene: String,
        /// Where recordings, tables and pictures go.
        #[arg(long, value_name = "FOLDER", default_value = "out/live")]
        out: std::path::PathBuf,
        /// Writes the shown numbers to this file four times per second, for scripts that drive the
        /// window.
        #[arg(long, value_name = "FILE", hide = true)]
        numbers: Option<std::path::PathBuf>,
    }

    /// The app, with its numbers written to a file.
    struct Told {
        app: App,
        numbers: Option<std::path::PathBuf>,
        next: std::time::Instant,
    }

    impl eframe::App for Told {
        fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
            self.app.ui(ui, frame);
            if let Some(file) = &self.numbers
                && self.next.elapsed().as_millis() >= 250
            {
                self.next = std::time::Instant::now();
                // complete or not at all: it may be read at any time
                let part = file.with_extension("part");
                if let Err(why) =
                    std::fs::write(&part, self.app.numbers().to_string()).and_then(|()| std::fs::rename(&part, file))
                {
                    eprintln!("palpate: {}: {why}", file.display());
                }
            }
        }

        fn on_exit(&mut self, gl: Option<&eframe::glow::Context>) {
            self.app.on_exit(gl);
        }
    }

    pub fn open() -> ExitCode {
        let arguments = Arguments::parse();
        let (choice, holding) = (Choice::preset(&arguments.scene), Holding::default());
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
            Box::new(|cc| {
                let app = App::new(&cc.egui_ctx, Box::new(link), choice, holding).into_folder(arguments.out);
                Ok(Box::new(Told { app, numbers: arguments.numbers, next: std::time::Instant::now() }))
            }),
        );
        match made {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                // a screen that is missing is reported with a place in a library's source
                let error = error.to_string().lines().next().unwrap_or_default().trim_end_matches(':').to_owned();
                eprintln!("palpate: no window: {error}: start it on a desktop, or take the page, `palpate live --page`");
                ExitCode::from(2)
            }
        }
    }
}
