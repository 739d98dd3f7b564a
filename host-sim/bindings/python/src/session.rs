//! A haptic session as a Python class.

use std::path::Path;
use std::sync::{Mutex, MutexGuard};

use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArray2, PyArrayLikeDyn, PyArrayMethods};
use palpate::haptic::commission::Stage;
use palpate::haptic::cycle::Telemetry;
use palpate::{Output, Vector3};
use palpate_loop::haptic_session::{HapticSession, Input};
use palpate_tissue::error::Error;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::{Bound, Py, PyAny, PyAnyMethods, PyResult, Python, pyclass, pyfunction, pymethods};
use pyo3::types::{PyDict, PyDictMethods};
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::{PalpateError, raised};

/// Record of a tick that [`Session::run`] and [`session_many`] return.
struct Row {
    force_n: Vector3<f32>,
    tissue_n: Vector3<f32>,
    normal: Vector3<f32>,
    depth_m: f32,
    mode: u8,
    fault: u8,
    limiters: u8,
}

impl Row {
    fn of(t: &Telemetry) -> Self {
        let Output { force_n, normal, depth_m, .. } = t.output;
        let (mode, fault, limiters) = (t.mode as u8, t.fault.map_or(0, |fault| fault as u8), t.limiters.bits());
        Self { force_n: t.applied_n, tissue_n: force_n, normal, depth_m, mode, fault, limiters }
    }
}

/// Returns the three numbers of a tick in a column.
type Wide = fn(&Row) -> Vector3<f32>;
const WIDE: [(&str, Wide); 3] = [("force_n", |row| row.force_n), ("tissue_n", |row| row.tissue_n), ("normal", |row| row.normal)];
/// Returns the number of a tick in a column of bytes.
type Byte = fn(&Row) -> u8;
const BYTES: [(&str, Byte); 3] = [("mode", |row| row.mode), ("fault", |row| row.fault), ("limiters", |row| row.limiters)];

/// Names of the modes, by number.
const MODES: [&str; 8] = ["boot", "self-test", "idle", "arming", "active", "degraded", "ramping down", "fault"];

/// The haptic loop around the caller's device.
///
/// `scene` is a preset's name or the path of a scene file; `patch` is the path of a patch file that
/// replaces the scene's, or is opened without a scene; `device` is a profile's name or the path of
/// a .toml file. There is no force before `arm`, and limits, ramp-in and passivity control act on
/// every force.
#[pyclass(frozen)]
pub struct Session {
    // locked without waiting: a second thread gets an error at once
    inner: Mutex<HapticSession>,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (scene=None, *, patch=None, device="touch"))]
    fn new(py: Python<'_>, scene: Option<&str>, patch: Option<&str>, device: &str) -> PyResult<Self> {
        let patch = patch.map(Path::new);
        py.detach(|| open(scene, patch, device)).map(|inner| Self { inner: Mutex::new(inner) }).map_err(|error| raised(&error))
    }

    /// Runs one tick: takes the position of the probe's tip [m] and returns the force on the device
    /// [N]. Call it every millisecond. The force is zero while a fault is latched: see `fault`.
    /// `orientation` turns the probe first, as `turn` does; a bad one raises, without a tick.
    #[pyo3(signature = (tip_m, *, orientation=None, late_ticks=0, stale=false, sensor_failed=false, operator_absent=false))]
    fn tick<'py>(
        &self,
        py: Python<'py>,
        tip_m: &Bound<'py, PyAny>,
        orientation: Option<[f32; 4]>,
        late_ticks: u16,
        stale: bool,
        sensor_failed: bool,
        operator_absent: bool,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let tip_m = numbers(tip_m, "tip_m", "x, y and z in m")?;
        let tip = tip_m.as_array();
        let &[3] = tip.shape() else {
            return Err(PyValueError::new_err(format!("tip_m has shape {:?}: give x, y and z in m", tip.shape())));
        };
        let tip_m = Vector3::new(tip[[0]], tip[[1]], tip[[2]]).cast();
        let mut session = self.inner()?;
        orientation.map_or(Ok(()), |orientation| session.turn(orientation)).map_err(|error| raised(&error))?;
        session.tick(&Input { tip_m, stale, sensor_failed, operator_absent, late_ticks });
        Ok(array(py, &session.drive_n()))
    }

    /// Runs one tick of a commissioning in place of `tick`: it measures order, sign, unit,
    /// friction, mass, delay and lag of the device, with 0.5 N at most. Takes the values of the
    /// three sensors, in any unit, and returns the forces for the three motors [N], to be sent at
    /// once, and the stage: "start", "move", "let go", "drive" or "done". `commission_text` says
    /// what the user has to do; pass `confirmed=True` in the one tick in which that is done.
    /// `distance_m` is the distance by which the user moves the handle along each axis.
    ///
    /// Raises `PalpateError` if it ends without a result; the profile then stays as it was.
    #[pyo3(signature = (reading, *, confirmed=false, distance_m=0.05))]
    fn commission<'py>(
        &self,
        py: Python<'py>,
        reading: &Bound<'py, PyAny>,
        confirmed: bool,
        distance_m: f64,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, &'static str)> {
        let reading = numbers(reading, "reading", "the values of three sensors")?;
        let values = reading.as_array();
        let &[3] = values.shape() else {
            return Err(PyValueError::new_err(format!(
                "reading has shape {:?}: give the values of three sensors",
                values.shape()
            )));
        };
        let reading = Vector3::new(values[[0]], values[[1]], values[[2]]).cast();
        let step = self.inner()?.commission(reading, distance_m as f32, confirmed);
        let step = step.map_err(|error| raised(&error))?;
        let stage = match step.stage {
            Stage::Start(_) => "start",
            Stage::Move(_) => "move",
            Stage::LetGo => "let go",
            Stage::Drive(_) => "drive",
            Stage::Done => "done",
            Stage::Stopped(_) => return Err(PalpateError::new_err(step.sentence(distance_m as f32))),
        };
        Ok((array(py, &step.force_n), stage))
    }

    /// Instruction to the user in the present step of a commissioning.
    #[pyo3(signature = (*, distance_m=0.05))]
    fn commission_text(&self, distance_m: f64) -> PyResult<String> {
        self.inner()?.commission_sentence(distance_m as f32).map_err(|error| raised(&error))
    }

    /// Writes the profile that the last commissioning completed to a file.
    fn write_profile(&self, path: &str) -> PyResult<()> {
        self.inner()?.write_profile(Path::new(path)).map_err(|error| raised(&error))
    }

    /// Values that the device's profile does not state, with the cautious ones that are taken: a
    /// list of sentences.
    #[getter]
    fn cautions(&self) -> PyResult<Vec<String>> {
        Ok(self.inner()?.cautions())
    }

    /// Runs ticks one after the other, without waiting in between. Takes positions [m] of shape (n,
    /// 3) and returns a dict of arrays with n rows: `force_n`, `tissue_n`, `normal`, `depth_m`,
    /// `mode`, `fault`, `limiters`.
    fn run<'py>(&self, py: Python<'py>, tips_m: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let tips_m = numbers(tips_m, "tips_m", "rows of x, y and z in m")?;
        let tips = tips_m.as_array();
        let &[count, 3] = tips.shape() else {
            return Err(PyValueError::new_err(format!("tips_m has shape {:?}: give rows of x, y and z in m", tips.shape())));
        };
        let row = |n: usize| Vector3::new(tips[[n, 0]], tips[[n, 1]], tips[[n, 2]]).cast();
        let tips: Vec<Vector3<f32>> = (0..count).map(row).collect();
        let mut inner = self.inner()?;
        let session = &mut *inner;
        trace(py, &py.detach(|| ticks(session, &tips)), &[count])
    }

    /// Contact of the tissue with the probe after the last tick: a dict of `normal_n`,
    /// `friction_n`, `torque_nm`, `centre_m`, `axes`, `half_lengths_m`, `area_m2`,
    /// `peak_pressure_pa`, and `pressure_pa` on each of `triangles`. All is zero without contact.
    ///
    /// Forces [N] and torque [N m] are those of the tissue on the probe, before damping, gains and
    /// limits of the loop; the torque is that of both forces about the tip, right-handed. It is
    /// computed when it is read, and changes no tick.
    fn read_contact<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut inner = self.inner()?;
        let mut pressure_pa = vec![0.0; inner.tissue().patch().model().triangles.len()];
        let map = inner.contact(&mut pressure_pa);
        let found = PyDict::new(py);
        let vectors =
            [("normal_n", map.force_n), ("friction_n", map.friction_n), ("torque_nm", map.torque_nm), ("centre_m", map.centre_m)];
        for (name, vector) in vectors {
            found.set_item(name, array(py, &vector))?;
        }
        found.set_item("axes", rows(py, map.axes.into_iter())?)?;
        found.set_item("half_lengths_m", map.half_lengths_m.map(f64::from).to_vec().into_pyarray(py))?;
        found.set_item("area_m2", f64::from(map.area_m2))?;
        found.set_item("peak_pressure_pa", f64::from(map.peak_pressure_pa))?;
        found.set_item("pressure_pa", pressure_pa.into_iter().map(f64::from).collect::<Vec<_>>().into_pyarray(py))?;
        Ok(found)
    }

    /// Requests force output. It begins once the probe has been outside the tissue and calm for a
    /// tenth of a second, and is then ramped up over half a second in free space.
    fn arm(&self) -> PyResult<()> {
        self.inner()?.arm().map_err(|error| raised(&error))
    }

    /// Ramps the force down to zero, and disarms.
    fn stop(&self) -> PyResult<()> {
        self.inner()?.stop();
        Ok(())
    }

    /// Requests that the next tick clear the fault. The tick refuses the request until readings
    /// have been good for a tenth of a second.
    fn clear(&self) -> PyResult<()> {
        self.inner()?.clear().map_err(|error| raised(&error))
    }

    /// Restarts the session: tissue at rest, no force, no fault, not armed.
    fn reset(&self) -> PyResult<()> {
        self.inner()?.reset().map_err(|error| raised(&error))
    }

    /// Turns the probe about its tip from the next tick on, to a rotation from its upright pose: a
    /// unit quaternion x, y, z, w in the scene's frame, by at most 45 degrees. It replaces the
    /// scene's tilt until the next call. Damping and friction act on the tip's displacement alone.
    fn turn(&self, orientation: [f32; 4]) -> PyResult<()> {
        self.inner()?.turn(orientation).map_err(|error| raised(&error))
    }

    /// Lowers the maximum force [N] for the rest of the session.
    fn lower_force(&self, max_force_n: f64) -> PyResult<()> {
        self.inner()?.lower_force(max_force_n as f32).map_err(|error| raised(&error))
    }

    /// Operating mode: "boot", "self-test", "idle", "arming", "active", "degraded", "ramping
    /// down" or "fault".
    #[getter]
    fn mode(&self) -> PyResult<String> {
        Ok(MODES[self.inner()?.mode() as usize].into())
    }

    /// Description of the latched fault, or None.
    #[getter]
    fn fault(&self) -> PyResult<Option<String>> {
        self.last(None, |t| t.fault.map(|fault| fault.to_string()))
    }

    /// Whether the probe touches the tissue.
    #[getter]
    fn contact(&self) -> PyResult<bool> {
        self.last(false, |t| t.output.normal != Vector3::zeros())
    }

    /// Depth of the tip below the undeformed surface [m].
    #[getter]
    fn depth_m(&self) -> PyResult<f64> {
        self.last(0.0, |t| f64::from(t.output.depth_m))
    }

    /// Force on the device after the last tick [N].
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(array(py, &self.inner()?.drive_n()))
    }

    /// Whether the last tick refused a request.
    #[getter]
    fn refused(&self) -> PyResult<bool> {
        self.last(false, |t| t.refused)
    }

    /// Young's modulus [Pa]. It can be set between half and twice the one with which the session
    /// was opened; an increase takes effect only when the probe does not touch the tissue.
    #[getter]
    fn youngs_modulus_pa(&self) -> PyResult<f64> {
        Ok(f64::from(self.inner()?.tissue().params().youngs_modulus_pa))
    }

    #[setter]
    fn set_youngs_modulus_pa(&self, value: f64) -> PyResult<()> {
        self.inner()?.set_modulus(value as f32).map_err(|error| raised(&error))
    }

    /// Site of the press on the surface at rest [m]; add it to positions relative to your device's
    /// centre.
    #[getter]
    fn site_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(array(py, &self.inner()?.tissue().patch().site_m()))
    }

    /// Unit vector that points out of the tissue at the site.
    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(array(py, &self.inner()?.tissue().params().probe.axis))
    }

    /// Maximum force of the loop [N].
    #[getter]
    fn max_force_n(&self) -> PyResult<f64> {
        Ok(f64::from(self.inner()?.limits().max_force_n))
    }

    /// Positions of all nodes [m], shape (nodes, 3).
    #[getter]
    fn nodes_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        Ok(rows(py, self.inner()?.tissue().nodes().iter().map(palpate::Node::position_m))?.unbind())
    }

    /// Triangles of the surface for drawing, shape (triangles, 3): indices of nodes,
    /// counter-clockwise seen from outside.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let corners: Vec<u32> =
            self.inner()?.tissue().patch().model().triangles.iter().flat_map(|t| t.node.map(u32::from)).collect();
        let count = corners.len() / 3;
        corners.into_pyarray(py).reshape([count, 3])
    }

    /// Hash of all positions and velocities of the tissue.
    #[getter]
    fn state_hash(&self) -> PyResult<u64> {
        Ok(self.inner()?.hash())
    }
}

fn open(scene: Option<&str>, patch: Option<&Path>, device: &str) -> Result<HapticSession, Error> {
    match (scene, patch) {
        (Some(scene), patch) => HapticSession::open(scene, patch, device),
        (None, Some(patch)) => HapticSession::open_patch(patch, device),
        (None, None) => HapticSession::open("block", None, device),
    }
}

/// Runs many sessions of one tissue, on all cores. Takes positions [m] of shape (sessions, ticks,
/// 3) and returns the dict of `Session.run`, whose arrays have the sessions in front: `tissue_n` is
/// the force of the tissue, and `force_n` that on the device, which follows the limits of the loop.
/// Each session begins at rest and armed, and gives the bits of a single one. `scene`, `patch` and
/// `device` are those of `Session`.
#[pyfunction]
#[pyo3(signature = (scene, tips_m, *, patch=None, device="touch"))]
pub fn session_many<'py>(
    py: Python<'py>,
    scene: Option<&str>,
    tips_m: &Bound<'py, PyAny>,
    patch: Option<&str>,
    device: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let tips_m = numbers(tips_m, "tips_m", "an array of shape (sessions, ticks, 3) in m, with short sessions padded")?;
    let tips = tips_m.as_array();
    let &[sessions, count, 3] = tips.shape() else {
        return Err(PyValueError::new_err(format!("tips_m has shape {:?}: give (sessions, ticks, 3) in m", tips.shape())));
    };
    let row = |n: usize, m: usize| Vector3::new(tips[[n, m, 0]], tips[[n, m, 1]], tips[[n, m, 2]]).cast();
    let tips: Vec<Vec<Vector3<f32>>> = (0..sessions).map(|n| (0..count).map(|m| row(n, m)).collect()).collect();
    let mut first = py.detach(|| open(scene, patch.map(Path::new), device)).map_err(|error| raised(&error))?;
    first.arm().map_err(|error| raised(&error))?;
    let found = py.detach(|| tips.par_iter().flat_map_iter(|tips| ticks(&mut first.clone(), tips)).collect::<Vec<Row>>());
    trace(py, &found, &[sessions, count])
}

fn ticks(session: &mut HapticSession, tips: &[Vector3<f32>]) -> Vec<Row> {
    tips.iter().map(|tip_m| Row::of(session.tick(&Input::at(*tip_m)))).collect()
}

/// The columns of ticks, as arrays with these first sides.
fn trace<'py>(py: Python<'py>, found: &[Row], sides: &[usize]) -> PyResult<Bound<'py, PyDict>> {
    let trace = PyDict::new(py);
    for (name, of) in WIDE {
        trace.set_item(name, rows(py, found.iter().map(of))?.reshape([sides, &[3]].concat())?)?;
    }
    let depths_m: Vec<f64> = found.iter().map(|row| f64::from(row.depth_m)).collect();
    trace.set_item("depth_m", depths_m.into_pyarray(py).reshape(sides.to_vec())?)?;
    for (name, of) in BYTES {
        trace.set_item(name, found.iter().map(of).collect::<Vec<u8>>().into_pyarray(py).reshape(sides.to_vec())?)?;
    }
    Ok(trace)
}

impl Session {
    fn inner(&self) -> PyResult<MutexGuard<'_, HapticSession>> {
        self.inner.try_lock().map_err(|_| {
            PalpateError::new_err(
                "another thread is in a call with this session: let one thread make the calls, or give each its own session",
            )
        })
    }

    /// Value of the last tick's record; `none` before the first tick.
    fn last<T>(&self, none: T, of: impl FnOnce(&Telemetry) -> T) -> PyResult<T> {
        Ok(self.inner()?.telemetry().map_or(none, of))
    }
}

/// The caller's numbers as an array; `wanted` says in the error what to give.
fn numbers<'py>(given: &Bound<'py, PyAny>, name: &str, wanted: &str) -> PyResult<PyArrayLikeDyn<'py, f64, AllowTypeChange>> {
    // NumPy would convert texts, and drop the imaginary parts of complex numbers
    let kind = given.getattr("dtype").and_then(|dtype| dtype.getattr("kind")?.extract::<char>());
    let array = if kind.is_ok_and(|kind| !"biuf".contains(kind)) { None } else { given.extract().ok() };
    array.ok_or_else(|| PyValueError::new_err(format!("{name} is ragged or not of numbers: give {wanted}")))
}

fn array<'py>(py: Python<'py>, v: &Vector3<f32>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, v.cast::<f64>().as_slice())
}

/// Vectors as an array of shape (n, 3).
pub fn rows<'py>(py: Python<'py>, vectors: impl Iterator<Item = Vector3<f32>>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let numbers: Vec<f64> = vectors.flat_map(|v| <[f64; 3]>::from(v.cast::<f64>())).collect();
    let count = numbers.len() / 3;
    numbers.into_pyarray(py).reshape([count, 3])
}
