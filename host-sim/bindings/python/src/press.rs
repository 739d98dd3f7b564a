//! Presses of scenes by the emulated finger, as arrays.

use numpy::IntoPyArray;
use palpate_tissue::error::Error;
use palpate_tissue::press::{Hold, Press, TickRow, run};
use palpate_tissue::reference_values;
use palpate_tissue::scene::{Change, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::session::standing::Standing;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::{Bound, PyAny, PyAnyMethods, PyResult, Python, pyfunction};
use pyo3::types::{PyDict, PyDictMethods};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use std::collections::BTreeMap;

use crate::raised;
use crate::session::rows;

/// Returns one number of a tick's row.
type Column = fn(&TickRow) -> f64;

/// Changes of a scene's keys, by the name of the key.
pub type Changes<'py> = BTreeMap<String, Bound<'py, PyAny>>;

/// A value as it is written in a scene file; `None` for a value that no key has.
fn toml(value: &Bound<'_, PyAny>) -> Option<String> {
    if let Ok(truth) = value.extract::<bool>() {
        return Some(truth.to_string());
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Some(whole.to_string());
    }
    if let Ok(number) = value.extract::<f64>() {
        // Rust writes NaN, TOML nan
        return Some(format!("{number:?}").to_lowercase());
    }
    if let Ok(text) = value.extract::<String>() {
        return Some(format!("{text:?}"));
    }
    if let Ok(table) = value.extract::<Changes<'_>>() {
        let keys: Option<Vec<String>> = table.iter().map(|(key, value)| Some(format!("{key} = {}", toml(value)?))).collect();
        return Some(format!("{{{}}}", keys?.join(", ")));
    }
    let values: Option<Vec<String>> = value.try_iter().ok()?.map(|value| toml(&value.ok()?)).collect();
    Some(format!("[{}]", values?.join(", ")))
}

/// A press, with what is known of its error.
struct Pressed {
    press: Press,
    /// Force of finite elements at each hold [N]; not a number where none is stored.
    elements_n: Vec<f64>,
    model: String,
    warnings: Vec<String>,
}

fn changes(set: &Changes<'_>) -> PyResult<Vec<Change>> {
    let change = |(key, value): (&String, &Bound<'_, PyAny>)| {
        let value = toml(value).ok_or_else(|| PyTypeError::new_err(format!("{key}: give a number, a text, a list or a dict")))?;
        format!("{key}={value}").parse::<Change>().map_err(|error| raised(&error))
    };
    set.iter().map(change).collect()
}

fn pressed(scene: &str, set: &[Change]) -> Result<Pressed, Error> {
    let scene = Scene::load_with(scene, set)?;
    let session = Session::prepare(&scene)?;
    let press = run(&scene, &session, |_| ())?;
    let elements_n = press.holds.iter().map(|hold| reference_values::at(&scene, hold.target).unwrap_or(f64::NAN)).collect();
    let model = Standing::of(&scene, &session).sentence(&scene);
    Ok(Pressed { press, elements_n, model, warnings: scene.warnings() })
}

/// Runs the press of a scene, as `palpate press` does. `scene` is a preset's name or the path of a
/// scene file; `set` changes its keys, as in `set={"tissue.youngs_modulus_pa": 5000}`.
///
/// Returns a dict: `t_s`, `tip_m`, `command_m`, `force_n`, `depth_m` and `tick_us` have one row per
/// tick; `hold_target`, `hold_force_n`, `hold_elements_n` and `hold_depth_m` have one row per hold;
/// `residual_m`, `state_hash` and `fault` are single values. `hold_elements_n` is the force of
/// finite elements, NaN where none is stored; `model` says how far the force is off, and `warnings`
/// names values that are probably in a wrong unit.
#[pyfunction]
#[pyo3(signature = (scene, *, set=None))]
pub fn press<'py>(py: Python<'py>, scene: &str, set: Option<Changes<'py>>) -> PyResult<Bound<'py, PyDict>> {
    let set = changes(&set.unwrap_or_default())?;
    let found = py.detach(|| pressed(scene, &set)).map_err(|error| raised(&error))?;
    dict(py, &found)
}

/// Runs a press for each dict of changes in `sets`, on all cores; returns a list of the dicts that
/// `press` returns, in the same order.
#[pyfunction]
pub fn press_many<'py>(py: Python<'py>, scene: &str, sets: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let form = "sets: give a list with a dict of changes for each press, as [{\"probe.radius_m\": 0.006}, {}]";
    let sets: Vec<Changes<'py>> = sets.extract().map_err(|_| PyTypeError::new_err(form))?;
    let sets = sets.iter().map(changes).collect::<PyResult<Vec<_>>>()?;
    let found: Vec<Result<Pressed, Error>> = py.detach(|| sets.into_par_iter().map(|set| pressed(scene, &set)).collect());
    let found = found.into_iter().enumerate().map(|(n, found)| {
        let found = found.map_err(|error| raised(&format!("sets[{n}]: {error}")))?;
        dict(py, &found)
    });
    found.collect()
}

fn dict<'py>(py: Python<'py>, found: &Pressed) -> PyResult<Bound<'py, PyDict>> {
    let (press, trace) = (&found.press, PyDict::new(py));
    let columns: [(&str, Column); 4] = [
        ("t_s", |row| row.t_s),
        ("command_m", |row| row.command_m),
        ("depth_m", |row| f64::from(row.output.depth_m)),
        ("tick_us", |row| f64::from(row.tick_us)),
    ];
    for (name, of) in columns {
        trace.set_item(name, press.ticks.iter().map(of).collect::<Vec<f64>>().into_pyarray(py))?;
    }
    trace.set_item("tip_m", rows(py, press.ticks.iter().map(|row| row.tip_m))?)?;
    trace.set_item("force_n", rows(py, press.ticks.iter().map(|row| row.output.force_n))?)?;
    for (name, of) in [
        ("hold_target", (|hold| hold.target) as fn(&Hold) -> f64),
        ("hold_force_n", |hold| hold.force_n),
        ("hold_depth_m", |hold| hold.depth_m),
    ] {
        trace.set_item(name, press.holds.iter().map(of).collect::<Vec<f64>>().into_pyarray(py))?;
    }
    trace.set_item("hold_elements_n", found.elements_n.clone().into_pyarray(py))?;
    trace.set_item("residual_m", press.residual_m)?;
    trace.set_item("state_hash", press.state_hash)?;
    trace.set_item("fault", press.fault.map(|fault| fault.to_string()))?;
    trace.set_item("model", &found.model)?;
    trace.set_item("warnings", &found.warnings)?;
    Ok(trace)
}
