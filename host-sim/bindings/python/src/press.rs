//! A press of a scene by the emulated finger, as arrays.

use numpy::IntoPyArray;
use palpate_tissue::press::{TickRow, run};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use pyo3::prelude::{Bound, PyResult, Python, pyfunction};
use pyo3::types::{PyDict, PyDictMethods};

use crate::raised;
use crate::session::rows;

/// Returns one number of a tick's row.
type Column = fn(&TickRow) -> f64;

/// Runs the press of a scene, as `palpate press` does. `scene` is a preset's name or the path of a
/// scene file.
///
/// Returns a dict: `t_s`, `tip_m`, `command_m`, `force_n`, `depth_m` and `tick_us` have one row per
/// tick; `hold_target`, `hold_force_n` and `hold_depth_m` have one row per hold; `residual_m`,
/// `state_hash` and `fault` are single values.
#[pyfunction]
pub fn press<'py>(py: Python<'py>, scene: &str) -> PyResult<Bound<'py, PyDict>> {
    let pressed = py.detach(|| {
        let scene = Scene::load(scene)?;
        let session = Session::prepare(&scene)?;
        run(&scene, &session, |_| ())
    });
    let press = pressed.map_err(|error| raised(&error))?;
    let trace = PyDict::new(py);
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
        ("hold_target", (|hold| hold.target) as fn(&palpate_tissue::press::Hold) -> f64),
        ("hold_force_n", |hold| hold.force_n),
        ("hold_depth_m", |hold| hold.depth_m),
    ] {
        trace.set_item(name, press.holds.iter().map(of).collect::<Vec<f64>>().into_pyarray(py))?;
    }
    trace.set_item("residual_m", press.residual_m)?;
    trace.set_item("state_hash", press.state_hash)?;
    trace.set_item("fault", press.fault.map(|fault| fault.to_string()))?;
    Ok(trace)
}
