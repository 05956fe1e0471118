//! Which device is fitted how: schedules that devices share are factorised once, everything else is a fit by itself.

use super::common::Scratch;
use super::device::Shape;
use super::lane_rows::{Form, Lanes};
use super::lanes::{Exact, Room};
use super::residuals::Tests;
use super::{Common, Device, Layout, Row, Solved};
use crate::campaign::Campaign;
use crate::error::Result;
use crate::fit::{self, Settings};
use pulp::Arch;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Schedules that are kept; more differ in every device, and are not common.
const MOST: usize = 256;
/// Devices that are worked on together.
const BLOCK: usize = 256;
/// Schedules met together from which on they count as many, and devices that make one of many worth to be factorised.
const VARIED: usize = 16;
const WORTH: usize = 48;
/// Devices of different schedules that are worked on together.
const SIDE_BY_SIDE: usize = 64;
/// Devices of one schedule that are worth more than their own fits, where eight go side by side to convergence.
const FEWEST: usize = 3;

/// A question to many devices.
pub struct Fleet<'a> {
    /// The campaign of one device.
    question: &'a (dyn Fn(&Device) -> Result<Campaign> + Sync),
    settings: Settings,
    /// Estimated parameters and derived quantities.
    quantities: usize,
    known: Schedules,
}

/// Schedules that were met.
#[derive(Default)]
pub struct Schedules {
    list: Vec<Schedule>,
    /// Schedules by the hash of their rows in order.
    ordered: HashMap<u64, usize>,
    /// Schedules that stood once.
    seen: HashSet<u64>,
    /// The schedule of the device before.
    last: Place,
    /// The way of devices of other schedules; inner `None` where there is none, outer where nobody has asked.
    lanes: Option<Option<Box<Lanes>>>,
    /// What the tests of their forms share.
    tests: HashMap<Form, Tests>,
}

/// A schedule of several devices.
struct Schedule {
    /// A device that has it.
    device: Device,
    /// Its rows in order.
    order: Vec<usize>,
    /// What devices share; `None` where each needs a fit of its own.
    common: Option<Box<Common>>,
}

/// How devices are solved together: by a schedule's factorisation, or each by a system of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Way {
    Common(usize),
    Lanes(Form),
}

/// One of them: its number, and the rows of the schedule's where they stand in another order.
struct Member<'a> {
    number: usize,
    device: &'a Device,
    map: Option<Vec<usize>>,
}

/// A device's place: a schedule and, where its rows stand in another order, the rows of the schedule's.
type Place = Option<(usize, Option<Vec<usize>>)>;

impl<'a> Fleet<'a> {
    /// No device yet. `question` makes the campaign of a device; what it refuses is that device's answer.
    pub fn new(
        question: &'a (dyn Fn(&Device) -> Result<Campaign> + Sync),
        settings: Settings,
        quantities: usize,
    ) -> Self {
        Fleet::with(question, settings, quantities, Schedules::default())
    }

    /// Devices of a table whose first devices have had these schedules.
    pub fn with(
        question: &'a (dyn Fn(&Device) -> Result<Campaign> + Sync),
        settings: Settings,
        quantities: usize,
        known: Schedules,
    ) -> Self {
        Fleet { question, settings, quantities, known }
    }

    /// The schedules that were met.
    pub fn into_schedules(self) -> Schedules {
        self.known
    }

    /// A row for each device, in their order.
    pub fn fit(&mut self, devices: &[Device], layout: &Layout) -> Vec<Row> {
        let places = self.places(devices, layout);
        let mut blocks: Vec<(Way, Vec<Member<'_>>)> = Vec::new();
        // devices of lines that follow the point go together with those of their schedule
        let mut open: HashMap<(Way, u64), usize> = HashMap::new();
        for ((number, device), place) in devices.iter().enumerate().zip(places) {
            let shape = Shape::of(device, layout);
            let (key, most, member) = match place {
                Some((schedule, map)) => ((Way::Common(schedule), 0), BLOCK, Member { number, device, map }),
                None => {
                    let Some((form, is_exact)) = self.side_by_side(device, layout) else { continue };
                    let schedule = if is_exact { shape.hash_in_order() } else { 0 };
                    let key = (Way::Lanes(form), schedule);
                    let first = open.get(&key).and_then(|block| blocks.get(*block)?.1.first());
                    if is_exact && first.is_some_and(|first| !shape.is_alike(&Shape::of(first.device, layout))) {
                        continue;
                    }
                    (key, SIDE_BY_SIDE, Member { number, device, map: None })
                }
            };
            let block = *open.entry(key).or_insert_with(|| {
                blocks.push((key.0, Vec::new()));
                blocks.len() - 1
            });
            let Some((_, members)) = blocks.get_mut(block) else { continue };
            members.push(member);
            if members.len() == most {
                open.remove(&key);
            }
        }
        let arch = Arch::new();
        let solved: Vec<(Vec<Member<'_>>, Vec<Option<Row>>)> = blocks
            .into_par_iter()
            .map_init(Default::default, |(scratch, room), (way, members)| {
                let found = match way {
                    Way::Common(schedule) => {
                        let common = self.known.list.get(schedule).and_then(|schedule| schedule.common.as_deref());
                        let devices: Vec<_> =
                            members.iter().map(|member| (member.device, member.map.as_deref())).collect();
                        common.map(|common| common.rows(arch, &devices, scratch))
                    }
                    Way::Lanes(form) => self.lane_rows(arch, &form, layout, &members, room),
                };
                // no rows: each of them is fitted by itself
                (members, found.unwrap_or_default())
            })
            .collect();
        let mut rows: Vec<Option<Row>> = vec![None; devices.len()];
        for (member, row) in solved.into_iter().flat_map(|(members, found)| members.into_iter().zip(found)) {
            if let Some(slot) = rows.get_mut(member.number) {
                *slot = row;
            }
        }
        rows.into_par_iter()
            .zip(devices.par_iter())
            .map(|(row, device)| {
                // what no common way has answered
                let row = row.unwrap_or_else(|| self.alone(arch, device, layout));
                Row { lot: device.lot.clone(), ..row }
            })
            .collect()
    }

    /// Is there a way for devices of schedules that few have? Asked once, of a device that makes a campaign.
    fn look_for_a_way(&mut self, device: &Device, layout: &Layout) {
        if self.known.lanes.is_none()
            && let Ok(campaign) = (self.question)(device)
        {
            self.known.lanes = Some(Lanes::new(&campaign, layout, &self.settings).map(Box::new));
        }
    }

    /// The form of a device whose schedule is its own, and whether its lines follow the point; `None` where it cannot go beside others.
    fn side_by_side(&mut self, device: &Device, layout: &Layout) -> Option<(Form, bool)> {
        self.look_for_a_way(device, layout);
        let way = self.known.lanes.as_ref()?.as_deref()?;
        let form = way.form_of(device)?;
        if self.known.tests.len() < MOST {
            self.known.tests.entry(form).or_insert_with(|| way.tests(&form));
        }
        Some((form, way.is_exact))
    }

    /// Rows of devices of one form, eight side by side; none where they have no such way, and for too few of a schedule whose lines follow the point.
    fn lane_rows(
        &self,
        arch: Arch,
        form: &Form,
        layout: &Layout,
        members: &[Member<'_>],
        room: &mut Room,
    ) -> Option<Vec<Option<Row>>> {
        let way = self.known.lanes.as_ref()?.as_deref()?;
        let tests = self.known.tests.get(form)?;
        let devices: Vec<&Device> = members.iter().map(|member| member.device).collect();
        if !way.is_exact {
            return Some(way.rows(arch, (form, tests), &devices, room));
        }
        let first = members.first().filter(|_| members.len() >= FEWEST)?;
        let sensors: Vec<usize> = layout.sensors().collect();
        let exact = Exact::new((self.question)(first.device).ok()?, &sensors)?;
        Some(way.rows_exactly(arch, (form, tests), &exact, &devices, room))
    }

    /// A fit by itself: a schedule of one device, or the ordinary fit.
    fn alone(&self, arch: Arch, device: &Device, layout: &Layout) -> Row {
        let fitted = (self.question)(device).and_then(|campaign| {
            let sensors: Vec<usize> = layout.sensors().collect();
            let common = Common::new(&campaign, &self.settings, &sensors).filter(|_| device.is_plain());
            let row =
                common.and_then(|common| common.rows(arch, &[(device, None)], &mut Scratch::default()).pop().flatten());
            match row {
                Some(row) => Ok(Row { solved: Solved::Alone, ..row }),
                None => fit::fit(&campaign, &self.settings).map(|fit| Row::of(device, &fit)),
            }
        });
        fitted.unwrap_or_else(|error| Row::without(&device.label, self.quantities, &error))
    }

    /// The schedule of each device; those that several devices share are factorised.
    fn places(&mut self, devices: &[Device], layout: &Layout) -> Vec<Place> {
        let shape = |device| Shape::of(device, layout);
        let mut places: Vec<Place> = Vec::with_capacity(devices.len());
        // schedules met for the first time: by the hash of their rows, the devices
        let mut new: HashMap<u64, Vec<usize>> = HashMap::new();
        let mut begun: Vec<u64> = Vec::new();
        for (k, device) in devices.iter().enumerate() {
            if !device.is_plain() || device.rows == 0 {
                places.push(None);
                continue;
            }
            if let Some(place) = self.as_before(&shape(device), layout) {
                places.push(Some(place));
                continue;
            }
            let hash = shape(device).hash_of_rows();
            let mut place = self.find(&shape(device), hash, layout);
            // a schedule that the next device has too, row by row, is common
            if place.is_none()
                && self.known.list.len() < MOST
                && let Some(next) = devices.get(k + 1).filter(|next| next.rows == device.rows)
                && shape(device).same(0..device.rows, &shape(next), 0..device.rows)
                && !self.known.ordered.contains_key(&hash)
                && !new.contains_key(&hash)
            {
                self.begin(device, hash, layout);
                place = self.find(&shape(device), hash, layout);
            }
            if place.is_none() {
                let of_hash = new.entry(hash).or_default();
                if of_hash.is_empty() {
                    begun.push(hash);
                }
                of_hash.push(k);
            }
            places.push(place);
        }
        // a schedule that few devices have costs more to factorise than it saves, where these can go side by side as they are
        let mut fewest = 2;
        if new.len() > VARIED {
            if let Some(device) = begun.first().and_then(|hash| devices.get(*new.get(hash)?.first()?)) {
                self.look_for_a_way(device, layout);
            }
            fewest = if matches!(self.known.lanes, Some(Some(_))) { WORTH } else { 2 };
        }
        for hash in begun {
            let Some(members) = new.remove(&hash) else { continue };
            if fewest > 2 && members.len() < fewest {
                continue;
            }
            if members.len() < 2 && !self.known.seen.contains(&hash) {
                if self.known.seen.len() < 1 << 20 {
                    self.known.seen.insert(hash);
                }
                continue;
            }
            let Some(first) = members.first().and_then(|k| devices.get(*k)) else { continue };
            let Some(index) = self.begin(first, hash, layout) else { continue };
            for k in members {
                let Some(device) = devices.get(k) else { continue };
                if let (Some(slot), Some(found)) = (places.get_mut(k), self.matched(index, &shape(device), layout)) {
                    *slot = Some((index, found));
                }
            }
        }
        for place in &mut places {
            let common = place.as_ref().and_then(|(k, _)| self.known.list.get(*k)).is_some_and(|s| s.common.is_some());
            if !common {
                *place = None;
            }
        }
        places
    }

    /// The schedule of the device before, row by row: most devices have it.
    fn as_before(&self, shape: &Shape<'_>, layout: &Layout) -> Place {
        let (index, map) = self.known.last.as_ref()?;
        let other = Shape::of(&self.known.list.get(*index)?.device, layout);
        let rows = 0..shape.device.rows;
        let same = match map {
            None => shape.is_alike(&other) || shape.same(rows.clone(), &other, rows),
            Some(map) => shape.same(map.iter().copied(), &other, rows),
        };
        if same { self.known.last.clone() } else { None }
    }

    /// A schedule that is known already.
    fn find(&mut self, shape: &Shape<'_>, hash: u64, layout: &Layout) -> Place {
        let index = *self.known.ordered.get(&hash)?;
        let map = self.matched(index, shape, layout)?;
        self.known.last = Some((index, map));
        self.known.last.clone()
    }

    /// The rows of a device in the order of a schedule's; inner `None` where that is its own, outer where it is another schedule.
    fn matched(&self, index: usize, shape: &Shape<'_>, layout: &Layout) -> Option<Option<Vec<usize>>> {
        let schedule = self.known.list.get(index)?;
        let other = Shape::of(&schedule.device, layout);
        if shape.is_alike(&other) {
            return Some(None);
        }
        let order = shape.order();
        if !shape.same(order.iter().copied(), &other, schedule.order.iter().copied()) {
            return None;
        }
        let mut map = vec![0; order.len()];
        for (place, others) in order.iter().zip(&schedule.order) {
            map.get_mut(*others).into_iter().for_each(|slot| *slot = *place);
        }
        let in_order = map.iter().enumerate().all(|(k, place)| k == *place);
        Some(if in_order { None } else { Some(map) })
    }

    /// Factorise a schedule; `None` where there are too many.
    fn begin(&mut self, device: &Device, hash: u64, layout: &Layout) -> Option<usize> {
        if self.known.list.len() >= MOST {
            return None;
        }
        let sensors: Vec<usize> = layout.sensors().collect();
        let common = (self.question)(device).ok();
        let common = common.and_then(|campaign| Common::new(&campaign, &self.settings, &sensors));
        let index = self.known.list.len();
        self.known.list.push(Schedule {
            device: device.clone(),
            order: Shape::of(device, layout).order(),
            common: common.map(Box::new),
        });
        self.known.ordered.insert(hash, index);
        Some(index)
    }
}
