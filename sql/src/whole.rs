//! Devices whose rows are kept together: the ordinary fit of each, with every check, by the fleet of `tumble fit --by`.

use crate::answer;
use crate::positions::numbers;
use crate::question::{Bound, Quantities};
use datafusion::arrow::array::{Array, ArrayRef, AsArray, BooleanArray, ListBuilder, PrimitiveBuilder};
use datafusion::arrow::datatypes::Float64Type;
use datafusion::common::{Result, ScalarValue, exec_datafusion_err};
use datafusion::logical_expr::{Accumulator, EmitTo, GroupsAccumulator};
use std::sync::Arc;
use tumble::batch::{Device, Fleet, Use};

/// Every device of a partition.
#[derive(Debug)]
pub(crate) struct Whole {
    bound: Arc<Bound>,
    quantities: Arc<Quantities>,
    /// Cells of each device, row after row, in the order of the columns.
    groups: Vec<Vec<f64>>,
    cells: usize,
}

impl Whole {
    pub(crate) fn new(bound: Arc<Bound>, quantities: Arc<Quantities>) -> Self {
        Whole { bound, quantities, groups: Vec::new(), cells: 0 }
    }

    fn grow(&mut self, total: usize) {
        self.groups.resize_with(total.max(self.groups.len()), Vec::new);
    }

    fn take(&mut self, emit: EmitTo) -> Vec<Vec<f64>> {
        let taken = emit.take_needed(&mut self.groups);
        self.cells = self.cells.saturating_sub(taken.iter().map(Vec::len).sum());
        taken
    }
}

impl GroupsAccumulator for Whole {
    fn update_batch(
        &mut self,
        values: &[ArrayRef],
        group_indices: &[usize],
        opt_filter: Option<&BooleanArray>,
        total_num_groups: usize,
    ) -> Result<()> {
        self.grow(total_num_groups);
        let columns = values.iter().map(numbers).collect::<Result<Vec<_>>>()?;
        for (row, place) in group_indices.iter().enumerate() {
            if opt_filter.is_some_and(|filter| !filter.is_valid(row) || !filter.value(row)) {
                continue;
            }
            let Some(group) = self.groups.get_mut(*place) else { continue };
            group.extend(columns.iter().map(|column| column.get(row).copied().unwrap_or(f64::NAN)));
            self.cells += columns.len();
        }
        Ok(())
    }

    fn evaluate(&mut self, emit_to: EmitTo) -> Result<ArrayRef> {
        let groups = self.take(emit_to);
        let bound = &self.bound;
        let width = bound.layout.uses.len().max(1);
        let devices: Vec<Device> = groups
            .into_iter()
            .map(|cells| {
                let mut device = Device { rows: cells.len() / width, ..Device::default() };
                for row in cells.chunks_exact(width) {
                    for (cell, kind) in row.iter().zip(&bound.layout.uses) {
                        match kind {
                            Use::Value(_) => device.values.push(*cell),
                            Use::Input | Use::Other => device.inputs.push(*cell),
                        }
                    }
                }
                device
            })
            .collect();
        let question = |device: &Device| bound.campaign(device);
        let rows = Fleet::new(&question, bound.settings, self.quantities.names.len()).fit(&devices, &bound.layout);
        Ok(Arc::new(answer::array(&rows, &self.quantities, true)))
    }

    fn state(&mut self, emit_to: EmitTo) -> Result<Vec<ArrayRef>> {
        let mut cells = ListBuilder::new(PrimitiveBuilder::<Float64Type>::new());
        for group in self.take(emit_to) {
            cells.values().append_slice(&group);
            cells.append(true);
        }
        Ok(vec![Arc::new(cells.finish())])
    }

    fn merge_batch(&mut self, values: &[ArrayRef], group_indices: &[usize], total_num_groups: usize) -> Result<()> {
        self.grow(total_num_groups);
        let cells = values.first().ok_or_else(|| exec_datafusion_err!("a state has one column"))?.as_list::<i32>();
        for (k, place) in group_indices.iter().enumerate().filter(|(k, _)| cells.is_valid(*k)) {
            let own = cells.value(k);
            let own = own.as_primitive::<Float64Type>();
            self.cells += own.len();
            self.groups.get_mut(*place).into_iter().for_each(|group| group.extend_from_slice(own.values()));
        }
        Ok(())
    }

    fn convert_to_state(&self, _: &[ArrayRef], _: Option<&BooleanArray>) -> Result<Vec<ArrayRef>> {
        Err(exec_datafusion_err!("rows are kept together"))
    }

    fn size(&self) -> usize {
        self.groups.capacity() * size_of::<Vec<f64>>() + 8 * self.cells
    }
}

impl Accumulator for Whole {
    fn update_batch(&mut self, values: &[ArrayRef]) -> Result<()> {
        let rows = values.first().map_or(0, |column| column.len());
        GroupsAccumulator::update_batch(self, values, &vec![0; rows], None, 1)
    }

    fn evaluate(&mut self) -> Result<ScalarValue> {
        self.grow(1);
        ScalarValue::try_from_array(&GroupsAccumulator::evaluate(self, EmitTo::All)?, 0)
    }

    fn size(&self) -> usize {
        GroupsAccumulator::size(self)
    }

    fn state(&mut self) -> Result<Vec<ScalarValue>> {
        self.grow(1);
        let columns = GroupsAccumulator::state(self, EmitTo::All)?;
        columns.iter().map(|column| ScalarValue::try_from_array(column, 0)).collect()
    }

    fn merge_batch(&mut self, states: &[ArrayRef]) -> Result<()> {
        let rows = states.first().map_or(0, |column| column.len());
        GroupsAccumulator::merge_batch(self, states, &vec![0; rows], 1)
    }
}
