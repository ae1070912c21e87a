//! The web package, browser tests, bench and fidelity: what `cargo xtask` hands on, with the same words.

mod bench;
mod browser;
mod fidelity;
mod step;
mod table;
mod web;

use anyhow::Result;
use step::Steps;
use xtask::setup;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut steps = Steps::default();
    match words.as_slice() {
        ["bench", .., "-h" | "--help"] => {
            print!("{}", bench::HELP);
            return Ok(());
        }
        ["fidelity", .., "-h" | "--help"] => {
            print!("{}", fidelity::HELP);
            return Ok(());
        }
        ["web"] => web_package(&mut steps, web::Size::Small, web::Warnings::Shown),
        ["web", "--fast"] => web_package(&mut steps, web::Size::Fast, web::Warnings::Shown),
        ["browser"] => browser_tests(&mut steps),
        // What is left of `cargo xtask test`.
        ["test"] => {
            web_package(&mut steps, web::Size::Small, web::Warnings::Refused);
            steps.run_counted("size of the web module", "20 s", web::check_size);
            browser_tests(&mut steps);
        }
        ["bench", options @ ..] => match bench::Options::parse(options) {
            Ok(options) => {
                steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
                steps.run("bench", "14 min, and 4 min to build", || bench::run(&options));
            }
            Err(error) => {
                eprintln!("error: {error}\nhint: cargo xtask bench --help lists tables and options");
                std::process::exit(2);
            }
        },
        ["fidelity", options @ ..] => match fidelity::Options::parse(options) {
            Ok(options) => {
                steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
                steps.run("fidelity", "3 min, and 4 min to build", || fidelity::run(&options));
            }
            Err(error) => {
                eprintln!("error: {error}\nhint: cargo xtask fidelity --help lists its options");
                std::process::exit(2);
            }
        },
        _ => {
            eprintln!("error: unknown command `{}`\nhint: cargo xtask --help lists what there is", words.join(" "));
            std::process::exit(2);
        }
    }
    steps.finish()
}

fn web_package(steps: &mut Steps, size: web::Size, warnings: web::Warnings) {
    steps.run("wasm target", "1 s; 2 min to install", || setup::wasm().map(drop));
    steps.run("web package", "4 min", || web::build(size, warnings));
}

fn browser_tests(steps: &mut Steps) {
    if !web::is_current() {
        println!("there is no web package of these sources in target/web: it is built as by `cargo xtask web --fast`");
        web_package(steps, web::Size::Fast, web::Warnings::Shown);
    }
    steps.run("browser", "1 s; 2 min to install", setup::browser);
    steps.run_counted("browser tests", "9 min", browser::test);
}
