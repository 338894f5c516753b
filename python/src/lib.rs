//! The Python package of RoboFin: it converts arguments and calls the crates. Its interface is described in
//! `robofin/_robofin.pyi` and `docs/python.md`.

mod arrays;
mod contact_tool;
mod environment;
mod errors;
mod field;
mod mesh;
mod model;
mod photograph;
mod program;
mod simulation;
mod tool;
mod trial;
mod welding;
mod workpiece;

use pyo3::prelude::*;

/// The compiled module.
#[pymodule]
fn _robofin(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("RoboFinError", py.get_type::<errors::RoboFinError>())?;
    module.add("WrongUse", py.get_type::<errors::WrongUse>())?;
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<field::Field>()?;
    module.add_class::<workpiece::Workpiece>()?;
    module.add_class::<workpiece::Snapshot>()?;
    module.add_class::<tool::Tool>()?;
    module.add_class::<tool::Path>()?;
    module.add_class::<tool::Record>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<simulation::SimulationSnapshot>()?;
    module.add_class::<contact_tool::ContactTool>()?;
    module.add_class::<trial::Trial>()?;
    module.add_class::<environment::Task>()?;
    module.add_class::<environment::Batch>()?;
    module.add_class::<environment::EnvironmentSnapshot>()?;
    module.add_function(wrap_pyfunction!(model::effects_of_library, module)?)?;
    module.add_function(wrap_pyfunction!(welding::weld, module)?)?;
    module.add_function(wrap_pyfunction!(photograph::photograph, module)?)?;
    module.add_function(wrap_pyfunction!(program::run, module)?)?;
    Ok(())
}
