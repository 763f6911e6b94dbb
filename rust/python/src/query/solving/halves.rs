//! `patterndb._native.query.solving.halves`.

use numpy::{PyReadonlyArray1, PyReadwriteArray2};
use patterndb_query::solving::halves::Transport;
use pyo3::prelude::*;

use super::list_classes;
use crate::arrays::{read, run};
use crate::rows::write_all;

#[pyfunction]
fn find_transport<'py>(
    py: Python<'py>,
    slack: PyReadonlyArray1<'py, i32>,
    class_i: PyReadonlyArray1<'py, i32>,
    class_j: PyReadonlyArray1<'py, i32>,
    n_classes: usize,
    closed: PyReadonlyArray1<'py, bool>,
    mut flow: PyReadwriteArray2<'py, i32>,
) -> PyResult<bool> {
    let (class_i, class_j) = (read(&class_i)?, read(&class_j)?);
    let classes = list_classes(class_i, class_j, &vec![1; n_classes]);
    let (slack, closed) = (read(&slack)?, read(&closed)?);
    let flow = write_all(&mut flow)?;
    run(py, || {
        let mut transport = Transport::default();
        let found = transport.find(slack, &classes, closed);
        let (there, back) = flow.split_at_mut(flow.len() / 2);
        for (k, found) in transport.flow().iter().enumerate() {
            [there[k], back[k]] = *found;
        }
        found
    })
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_transport, module)?)
}
