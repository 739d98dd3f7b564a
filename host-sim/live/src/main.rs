//! Opens the window.

#[cfg(not(target_family = "wasm"))]
fn main() -> std::process::ExitCode {
    window::open()
}

#[cfg(target_family = "wasm")]
fn main() {}

#[cfg(not(target_family = "wasm"))]
mod window {
    use std::path::{Path, PathBuf};
    use std::process::ExitCode;
    use std::sync::PoisonError;

    use clap::Parser;
    use eframe::egui;
    use palpate_live::app::App;
    use palpate_live::follow::{Feed, Follow, Given};
    use palpate_live::link::thread::Thread;
    use palpate_loop::board_trace;
    use palpate_loop::live::{Choice, Holding};

    /// Press tissue with the mouse, or follow a board.
    #[derive(Parser)]
    #[command(name = "palpate live")]
    struct Arguments {
        /// A preset or the path of a scene file (.toml) [default: block; with --follow the patch of
        /// the board, if it ships].
        #[arg(long, value_name = "NAME|FILE")]
        scene: Option<String>,
        /// Shows what a board measured, from the file that `palpate board arm --stream` is writing.
        #[arg(long, value_name = "FILE.csv")]
        follow: Option<PathBuf>,
        /// Patch file of the board that is followed.
        #[arg(long, value_name = "PATCH", requires = "follow", conflicts_with = "scene")]
        patch: Option<PathBuf>,
        /// Folder of recordings, tables and pictures.
        #[arg(long, value_name = "FOLDER", default_value = "out/live")]
        out: PathBuf,
        /// Writes the shown numbers to this file four times per second, for scripts that drive the
        /// window.
        #[arg(long, value_name = "FILE", hide = true)]
        numbers: Option<PathBuf>,
    }

    /// A window that can print the numbers that it shows.
    trait Numbered: eframe::App {
        fn numbers(&self) -> String;
    }

    impl Numbered for App {
        fn numbers(&self) -> String {
            App::numbers(self).to_string()
        }
    }

    impl Numbered for Follow {
        fn numbers(&self) -> String {
            Follow::numbers(self).to_string()
        }
    }

    /// An app whose shown numbers are also written to a file, four times per second.
    struct Told {
        app: Box<dyn Numbered>,
        numbers: Option<PathBuf>,
        next: std::time::Instant,
    }

    impl eframe::App for Told {
        fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
            self.app.ui(ui, frame);
            if let Some(file) = &self.numbers
                && self.next.elapsed().as_millis() >= 250
            {
                self.next = std::time::Instant::now();
                // the file is written completely or not at all, since it may be read at any time
                let part = file.with_extension("part");
                if let Err(why) = std::fs::write(&part, self.app.numbers()).and_then(|()| std::fs::rename(&part, file)) {
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
        let shown = match &arguments.follow {
            Some(file) => board(file, &arguments),
            None => tissue(&arguments),
        };
        shown.unwrap_or_else(|error| {
            eprintln!("palpate: {error}");
            ExitCode::from(2)
        })
    }

    /// Shows tissue to press with the mouse.
    fn tissue(arguments: &Arguments) -> Result<ExitCode, String> {
        let scene = arguments.scene.as_deref().unwrap_or("block");
        let (choice, holding) = (Choice::preset(scene), Holding::default());
        choice.scene().map_err(|error| error.to_string())?;
        let (link, out) = (Thread::start(choice.clone(), holding.clone()), arguments.out.clone());
        window("Palpate live", arguments, move |ctx| Box::new(App::new(ctx, Box::new(link), choice, holding).into_folder(out)))?;
        Ok(ExitCode::SUCCESS)
    }

    /// Shows a board, from the file to which its records are written.
    fn board(file: &Path, arguments: &Arguments) -> Result<ExitCode, String> {
        let given = Given::of(arguments.scene.as_deref(), arguments.patch.as_deref())?;
        board_trace::check_head(file)?;
        let (feed, name, out) = (Feed::start(file, given), file.display().to_string(), arguments.out.clone());
        let refused = feed.refused();
        window("Palpate live: board", arguments, move |ctx| Box::new(Follow::new(ctx, feed, name, out)))?;
        match refused.lock().unwrap_or_else(PoisonError::into_inner).take() {
            // the file was replaced by one that is not a board's table, as the window said
            Some(why) => Err(why),
            None => Ok(ExitCode::SUCCESS),
        }
    }

    fn window(title: &str, arguments: &Arguments, app: impl FnOnce(&egui::Context) -> Box<dyn Numbered>) -> Result<(), String> {
        let size = egui::vec2(1280.0, 720.0);
        let viewport = egui::ViewportBuilder::default().with_inner_size(size).with_title(title).with_app_id("palpate");
        let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
        let numbers = arguments.numbers.clone();
        let told = |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
            Ok(Box::new(Told { app: app(&cc.egui_ctx), numbers, next: std::time::Instant::now() }))
        };
        eframe::run_native(title, options, Box::new(told)).map_err(|error| {
            // the error of a missing display ends with a position in a library's source
            let error = error.to_string().lines().next().unwrap_or_default().trim_end_matches(':').to_owned();
            let fix = match arguments.follow {
                Some(_) => "start it on a desktop",
                None => "start it on a desktop, or take the page, `palpate live --page`",
            };
            format!("no window: {error}: {fix}")
        })
    }
}
